/* The Sideslip profile for C. Written by `firmware-profile --c-header`; SI and radians; NaN is no number. */
#ifndef SIDESLIP_H
#define SIDESLIP_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#define SIDESLIP_ASSERT static_assert
#else
#define SIDESLIP_ASSERT _Static_assert
#endif

#define SIDESLIP_CHANNELS 24
#define SIDESLIP_AXES 6
#define SIDESLIP_VARIABLES 10
/* Memory of a profile on a 64-bit host, bytes; elsewhere it is less, see sideslip_profile_bytes. */
#define SIDESLIP_PROFILE_BYTES 294464
#define SIDESLIP_PROFILE_ALIGNMENT 64

/* Places in SideslipSample.channels. */
enum {
    SIDESLIP_CHANNEL_AX = 0,
    SIDESLIP_CHANNEL_AY = 1,
    SIDESLIP_CHANNEL_AZ = 2,
    SIDESLIP_CHANNEL_P = 3,
    SIDESLIP_CHANNEL_Q = 4,
    SIDESLIP_CHANNEL_R = 5,
    SIDESLIP_CHANNEL_PHI = 6,
    SIDESLIP_CHANNEL_THETA = 7,
    SIDESLIP_CHANNEL_PSI = 8,
    SIDESLIP_CHANNEL_TAS = 9,
    SIDESLIP_CHANNEL_ALPHA = 10,
    SIDESLIP_CHANNEL_BETA = 11,
    SIDESLIP_CHANNEL_ALTITUDE = 12,
    SIDESLIP_CHANNEL_LON_CYCLIC = 13,
    SIDESLIP_CHANNEL_LAT_CYCLIC = 14,
    SIDESLIP_CHANNEL_COLLECTIVE = 15,
    SIDESLIP_CHANNEL_PEDAL = 16,
    SIDESLIP_CHANNEL_TAIL_PITCH = 17,
    SIDESLIP_CHANNEL_ROTOR_SPEED = 18,
    SIDESLIP_CHANNEL_TORQUE = 19,
    SIDESLIP_CHANNEL_FLAP_0 = 20,
    SIDESLIP_CHANNEL_FLAP_1C = 21,
    SIDESLIP_CHANNEL_FLAP_1S = 22,
    SIDESLIP_CHANNEL_RHO = 23,
};

/* Equations: forces X Y Z by mass, moments L M N as angular accelerations. */
enum {
    SIDESLIP_AXIS_X = 0,
    SIDESLIP_AXIS_Y = 1,
    SIDESLIP_AXIS_Z = 2,
    SIDESLIP_AXIS_L = 3,
    SIDESLIP_AXIS_M = 4,
    SIDESLIP_AXIS_N = 5,
};

/* What a derivative is taken with respect to. */
enum {
    SIDESLIP_VARIABLE_U = 0,
    SIDESLIP_VARIABLE_V = 1,
    SIDESLIP_VARIABLE_W = 2,
    SIDESLIP_VARIABLE_P = 3,
    SIDESLIP_VARIABLE_Q = 4,
    SIDESLIP_VARIABLE_R = 5,
    SIDESLIP_VARIABLE_LON_CYCLIC = 6,
    SIDESLIP_VARIABLE_LAT_CYCLIC = 7,
    SIDESLIP_VARIABLE_COLLECTIVE = 8,
    SIDESLIP_VARIABLE_PEDAL = 9,
};

/* How far along an answer is; there are numbers from STALE on; CONVERGED alone is to be relied upon. */
enum {
    SIDESLIP_NOT_IDENTIFIABLE = 0,
    SIDESLIP_WAITING = 1,
    SIDESLIP_EXCITING = 2,
    SIDESLIP_STALE = 3,
    SIDESLIP_DEPENDS_ON_AMPLITUDE = 4,
    SIDESLIP_DISAGREE = 5,
    SIDESLIP_CONVERGING = 6,
    SIDESLIP_CONVERGED = 7,
};

/* Why an answer is NOT_IDENTIFIABLE. */
enum {
    SIDESLIP_REASON_NO_RATES = 0,
    SIDESLIP_REASON_NO_ACCELEROMETER = 1,
    SIDESLIP_REASON_RATE_TOO_LOW = 2,
    SIDESLIP_REASON_UNOBSERVED = 3,
    SIDESLIP_REASON_COLLINEAR = 4,
    SIDESLIP_REASON_NOT_EXCITED = 5,
    SIDESLIP_REASON_EQUATION = 6,
    SIDESLIP_REASON_NO_TRIM = 7,
    SIDESLIP_REASON_AID_REJECTED = 8,
    SIDESLIP_REASON_UNRESOLVED = 9,
    SIDESLIP_REASON_INSTRUMENT_DOUBTED = 10,
    SIDESLIP_REASON_NOT_CONFIRMED = 11,
    SIDESLIP_REASON_NO_INPUT = 12,
    SIDESLIP_REASON_NO_CONTROL = 13,
};
#define SIDESLIP_NO_REASON 4294967295u

/* Errors, and what is none. */
#define SIDESLIP_NO_POINTER (-1)
#define SIDESLIP_TOO_SMALL (-2)
#define SIDESLIP_NOTHING_YET 2

typedef struct {
    double time_s;
    double channels[SIDESLIP_CHANNELS];
} SideslipSample;

/* A value and its standard error each. */
typedef struct {
    double omega[2];
    double zeta[2];
} SideslipMode;

typedef struct {
    double time_s;
    double derivatives[SIDESLIP_AXES][SIDESLIP_VARIABLES];
    double standard_errors[SIDESLIP_AXES][SIDESLIP_VARIABLES];
    SideslipMode dutch_roll;
    uint32_t status[SIDESLIP_AXES];
    uint32_t reason[SIDESLIP_AXES];
    uint32_t modes_status;
    uint32_t modes_reason;
} SideslipEstimates;

SIDESLIP_ASSERT(sizeof(SideslipSample) == 200, "SideslipSample is not the library's");
SIDESLIP_ASSERT(sizeof(SideslipMode) == 32, "SideslipMode is not the library's");
SIDESLIP_ASSERT(sizeof(SideslipEstimates) == 1056, "SideslipEstimates is not the library's");
SIDESLIP_ASSERT(offsetof(SideslipEstimates, status) == 1000, "SideslipEstimates is not the library's");

/* Bytes of memory that a profile needs, aligned to SIDESLIP_PROFILE_ALIGNMENT. */
size_t sideslip_profile_bytes(void);
/* Makes a profile of that memory, ready for a run. 0, SIDESLIP_NO_POINTER or SIDESLIP_TOO_SMALL. */
int32_t sideslip_init(void *memory, size_t bytes);
/* One sample. 1 where estimates are new, else 0, or SIDESLIP_NO_POINTER. */
int32_t sideslip_step(void *profile, const SideslipSample *sample);
/* Copies the newest estimates. 0, SIDESLIP_NOTHING_YET before any, or SIDESLIP_NO_POINTER. */
int32_t sideslip_estimates(const void *profile, SideslipEstimates *estimates);

#ifdef __cplusplus
}
#endif

#endif
