/* Flies the samples of a file through the profile and prints a fingerprint of all estimates: FNV-1a over their bytes. */
#include "sideslip.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

static uint64_t fingerprint = UINT64_C(0xcbf29ce484222325);

static void take(const void *bytes, size_t count)
{
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < count; i++)
        fingerprint = (fingerprint ^ byte[i]) * UINT64_C(0x100000001b3);
}

int main(int count, char **arguments)
{
    static SideslipEstimates estimates;
    SideslipSample sample;
    void *memory = aligned_alloc(SIDESLIP_PROFILE_ALIGNMENT, SIDESLIP_PROFILE_BYTES);
    FILE *file = count == 2 ? fopen(arguments[1], "rb") : NULL;
    if (memory == NULL || file == NULL)
        return 2;
    if (sideslip_profile_bytes() != SIDESLIP_PROFILE_BYTES)
        return 3;
    if (sideslip_init(NULL, SIDESLIP_PROFILE_BYTES) != SIDESLIP_NO_POINTER)
        return 4;
    if (sideslip_init((char *)memory + 1, SIDESLIP_PROFILE_BYTES) != SIDESLIP_NO_POINTER)
        return 5;
    if (sideslip_init(memory, SIDESLIP_PROFILE_BYTES - 1) != SIDESLIP_TOO_SMALL)
        return 6;
    /* A second run in the same memory begins as the first did. */
    for (int run = 0; run < 2; run++) {
        if (sideslip_init(memory, SIDESLIP_PROFILE_BYTES) != 0)
            return 7;
        if (sideslip_estimates(memory, &estimates) != SIDESLIP_NOTHING_YET || estimates.status[SIDESLIP_AXIS_N] != SIDESLIP_WAITING)
            return 8;
        if (sideslip_step(memory, NULL) != SIDESLIP_NO_POINTER || sideslip_estimates(memory, NULL) != SIDESLIP_NO_POINTER)
            return 9;
        rewind(file);
        int published = 0;
        while (fread(&sample, sizeof sample, 1, file) == 1) {
            int32_t brought = sideslip_step(memory, &sample);
            if (brought < 0)
                return 10;
            if (brought == 1) {
                published++;
                if (sideslip_estimates(memory, &estimates) != 0)
                    return 11;
                take(&estimates, sizeof estimates);
            }
        }
        printf("%d %016" PRIx64 " %u %.17g %.17g\n", published, fingerprint, (unsigned)estimates.status[SIDESLIP_AXIS_N],
               estimates.derivatives[SIDESLIP_AXIS_N][SIDESLIP_VARIABLE_PEDAL], estimates.dutch_roll.zeta[0]);
        fingerprint = UINT64_C(0xcbf29ce484222325);
    }
    fclose(file);
    free(memory);
    return 0;
}
