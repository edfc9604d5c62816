//! What pymavlink 2.4.50 and pyulog 1.3.0 find in the recordings, and in the simulated logs that are written here: counts and
//! digests, printed by `peer_logs.py`.

/// Messages of `plane-3.8.2.BIN` in all: count and digest.
pub(crate) const DATAFLASH_ALL: (u64, u64) = (1731, 0xa226_0c05_e689_3918);

/// Messages of `plane-3.8.2.BIN` by name: count and digest.
#[rustfmt::skip]
pub(crate) const DATAFLASH: [(&str, u64, u64); 47] = [
    ("AETR", 23, 0xacb8_097d_bc8a_abe5),
    ("AHR2", 23, 0x9d7d_5543_57ec_9ef7),
    ("AOA", 23, 0xbb71_62e4_4d66_7456),
    ("ATT", 24, 0xcbf1_83cc_9d69_f523),
    ("BARO", 8, 0xfc75_dd9b_fa7d_0394),
    ("BAT", 8, 0xc9fe_8bec_d63a_0594),
    ("CMD", 12, 0xad1c_c31e_f773_c7f7),
    ("CTUN", 23, 0xcfac_3662_d0b9_4bf9),
    ("FMT", 132, 0x32de_acec_8f12_f58a),
    ("GPA", 5, 0x0df2_345c_7d47_b419),
    ("GPS", 5, 0x6a3b_8cb1_80d9_7cc8),
    ("IMU", 45, 0x37a1_e3dc_c2fd_f8a9),
    ("IMU2", 45, 0xd6c2_31c6_f449_846f),
    ("MAG", 8, 0x62e3_f88d_2644_da27),
    ("MAG2", 8, 0x6725_0e8c_a8ad_3ec7),
    ("MAG3", 8, 0xdc4c_4add_f427_7461),
    ("MODE", 1, 0x64b6_aea3_c59c_64b9),
    ("MSG", 6, 0x2f73_aa40_58a4_4958),
    ("NKF1", 24, 0xa6fe_0f39_92ec_838d),
    ("NKF2", 24, 0xa039_df30_ef71_76b1),
    ("NKF3", 24, 0x8489_07e6_f26a_6e1d),
    ("NKF4", 24, 0x30cf_5570_a263_32e2),
    ("NKF5", 24, 0xc6f1_918e_9b31_c555),
    ("NKF6", 24, 0x6515_ec4d_5fdd_f1b2),
    ("NKF7", 24, 0x58d0_cef8_52b6_ac69),
    ("NKF8", 24, 0xd747_142f_942d_c0e9),
    ("NKF9", 24, 0xb84f_f04d_f2f3_b284),
    ("NKQ1", 24, 0xfbb2_e98e_b090_bf1f),
    ("NKQ2", 24, 0xcd70_988d_021b_fa6f),
    ("NTUN", 23, 0xd766_5e85_bb5a_6326),
    ("ORGN", 2, 0x90ad_8dac_5e23_406e),
    ("PARM", 809, 0xdf68_77e9_f694_abdf),
    ("PIDP", 24, 0xae90_ed17_8c69_3018),
    ("PIDR", 24, 0x1b4e_45bf_e9d4_b965),
    ("PIDS", 24, 0xd205_851d_6357_c5e5),
    ("PIDY", 24, 0x8476_4ecc_c0f6_fe99),
    ("PM", 1, 0x6198_8b31_c999_c523),
    ("POS", 23, 0x3192_3484_de20_38b8),
    ("POWR", 8, 0xb8e9_2035_9a73_aeb7),
    ("RAD", 1, 0x28e5_3237_4a56_4059),
    ("RCIN", 23, 0x2147_fa6b_ce8c_46ae),
    ("RCOU", 23, 0x2135_d25e_e74a_555a),
    ("RSSI", 23, 0x9fbc_852f_3c73_f55d),
    ("STAT", 3, 0x00ea_6b0e_b3d5_c844),
    ("STRT", 1, 0xf2a8_f75b_9384_5e8e),
    ("TERR", 1, 0xb6f2_cc82_7eb4_990a),
    ("VIBE", 23, 0x1180_f00d_db2c_3a44),
];

/// Data of `sample_log_small.ulg` by topic and instrument: count and digest.
#[rustfmt::skip]
pub(crate) const ULOG: [(&str, u8, u64, u64); 70] = [
    ("actuator_armed", 0, 14, 0xf1ea_eaba_9ef7_8317),
    ("actuator_controls_0", 0, 1812, 0x455a_3702_7c85_28c9),
    ("actuator_controls_1", 0, 1812, 0xd5a3_38f4_57c1_7959),
    ("actuator_outputs", 0, 65, 0x3fe1_fc40_512c_b899),
    ("actuator_outputs", 1, 65, 0x0dab_91f5_50f9_3170),
    ("airspeed", 0, 595, 0xf347_5e9f_3663_9980),
    ("airspeed_validated", 0, 8, 0x8925_ac35_3d54_02c4),
    ("battery_status", 0, 21, 0xcf27_21a8_0449_e7da),
    ("battery_status", 1, 21, 0xc2f1_6a8b_d908_bb68),
    ("commander_state", 0, 14, 0x05c7_e607_50ba_38c1),
    ("cpuload", 0, 14, 0xaf57_6a99_16e4_95f6),
    ("differential_pressure", 0, 6, 0xa612_b68f_0a45_6c54),
    ("differential_pressure", 1, 6, 0x1233_04d9_52ca_093b),
    ("ekf2_timestamps", 0, 1297, 0xbfb0_b903_0d36_1cdf),
    ("ekf_gps_drift", 0, 28, 0x6ebe_4a06_6413_79e5),
    ("estimator_innovation_test_ratios", 0, 33, 0xf474_6612_d442_7c80),
    ("estimator_innovation_variances", 0, 33, 0x3b69_84a5_68e9_5b2d),
    ("estimator_innovations", 0, 33, 0x3da8_69c5_3dfa_2ab8),
    ("estimator_sensor_bias", 0, 7, 0xacf2_3fd3_f332_0395),
    ("estimator_status", 0, 636, 0xbcf6_f9c2_efcb_a9d3),
    ("input_rc", 0, 13, 0x53ab_04a4_8acc_ff52),
    ("logger_status", 0, 7, 0xa402_8c19_b406_e4e0),
    ("manual_control_setpoint", 0, 33, 0xebe4_366e_1094_fb09),
    ("mission", 0, 1, 0x3fd5_c350_d0f6_bfa0),
    ("multirotor_motor_limits", 0, 7, 0xc753_6f28_7d6c_da47),
    ("position_setpoint_triplet", 0, 1, 0xad23_e725_56dc_1ea5),
    ("px4io_status", 0, 7, 0x08e7_a5be_9a16_78e6),
    ("rate_ctrl_status", 0, 33, 0x9981_c073_c0b6_0d4d),
    ("safety", 0, 8, 0x47d5_e1df_24cf_80ff),
    ("sensor_accel", 0, 6, 0xc0bf_a4d7_07ad_1c0c),
    ("sensor_accel", 1, 6, 0x857e_baa5_2440_d964),
    ("sensor_accel", 2, 6, 0x64d7_1df4_7842_bca9),
    ("sensor_baro", 0, 6, 0xeacf_4e7b_c417_b0a0),
    ("sensor_baro", 1, 6, 0xa9f9_b154_5866_c520),
    ("sensor_combined", 0, 1298, 0xe4f3_4f1e_cd8c_9e25),
    ("sensor_gyro", 0, 6, 0x235d_f6c1_2cc6_a183),
    ("sensor_gyro", 1, 6, 0x4329_ccd4_c91b_adf8),
    ("sensor_gyro", 2, 6, 0x2404_42a9_2257_7318),
    ("sensor_mag", 0, 6, 0xd586_4ce0_44f7_a1f7),
    ("sensor_mag", 1, 6, 0x18fa_bf5c_4ba4_38a3),
    ("sensor_preflight", 0, 7, 0xced9_a3fa_7a53_831f),
    ("sensor_selection", 0, 1, 0xf1e4_dd77_207c_5ade),
    ("system_power", 0, 13, 0x6753_b325_f07c_4274),
    ("telemetry_status", 0, 8, 0xc7fa_9b5f_04f2_2047),
    ("telemetry_status", 1, 8, 0x42b5_5d59_47d6_a513),
    ("test_motor", 0, 1, 0xa09d_945a_1cd8_d6e5),
    ("vehicle_air_data", 0, 120, 0x093a_7122_1980_3636),
    ("vehicle_angular_acceleration", 0, 1811, 0xc5b2_a248_2e20_234d),
    ("vehicle_angular_velocity", 0, 1812, 0xcfec_e605_c242_1e38),
    ("vehicle_attitude", 0, 1298, 0xdc64_9476_cddb_6630),
    ("vehicle_attitude_setpoint", 0, 65, 0xb28c_f21f_67e1_95ba),
    ("vehicle_command", 0, 1, 0x48a5_9029_6c21_55f2),
    ("vehicle_control_mode", 0, 14, 0xd4d2_80f3_3805_b486),
    ("vehicle_gps_position", 0, 32, 0x2a90_9561_86c8_941b),
    ("vehicle_imu", 0, 12, 0x92bd_1109_2d3a_cda4),
    ("vehicle_imu", 1, 12, 0xf0f3_7210_32a8_9314),
    ("vehicle_imu", 2, 12, 0x9376_e4b1_e95b_ec59),
    ("vehicle_imu_status", 0, 6, 0xe6c9_f177_7b71_069a),
    ("vehicle_imu_status", 1, 7, 0xba63_0958_3eec_1c5a),
    ("vehicle_imu_status", 2, 6, 0x2137_7e44_79d5_8fd0),
    ("vehicle_land_detected", 0, 11, 0x49f8_3883_330a_0edc),
    ("vehicle_local_position", 0, 636, 0xae8f_6a24_c07f_021f),
    ("vehicle_magnetometer", 0, 319, 0x92d4_064c_0b2f_22aa),
    ("vehicle_rates_setpoint", 0, 319, 0x889f_720a_c36d_9dbf),
    ("vehicle_status", 0, 14, 0x043f_2a2e_220f_16c5),
    ("vehicle_status_flags", 0, 14, 0x8264_1e06_ede2_c8af),
    ("vtol_vehicle_status", 0, 33, 0x4af6_db70_286b_0472),
    ("wind_estimate", 0, 8, 0x788b_5e3a_727d_c68d),
    ("wind_estimate", 1, 8, 0x788b_5e3a_727d_c68d),
    ("yaw_estimator_status", 0, 8, 0x4f9f_53b1_8069_fcae),
];

/// Parameters of `sample_log_small.ulg`: count and digest.
pub(crate) const PARAMETERS: (u64, u64) = (980, 0xf903_5b29_15c3_a4a1);

/// Lines of text of `sample_log_small.ulg`: count and digest.
pub(crate) const TEXT: (u64, u64) = (3, 0xb550_7967_5296_a0eb);

/// Information of `sample_log_small.ulg`: count and digest.
pub(crate) const INFORMATION: (u64, u64) = (14, 0xdd27_8a3a_5687_e585);

/// Messages of the simulated dataflash log by name: count and digest.
#[rustfmt::skip]
pub(crate) const WRITTEN_DATAFLASH: [(&str, u64, u64); 10] = [
    ("AOA", 182, 0x4994_ee20_5458_6188),
    ("ARSP", 182, 0x40de_5622_c89d_1c45),
    ("ATT", 200, 0x35e6_df0d_d216_2bcf),
    ("BARO", 182, 0xc94b_f0b8_0331_5c16),
    ("FMT", 10, 0x3d50_e660_fac4_5f3d),
    ("FMTU", 6, 0xde4f_3a54_99d5_8408),
    ("IMU", 500, 0x21fa_b375_38c4_6a15),
    ("MULT", 4, 0xa424_04f0_e951_24ad),
    ("RCOU", 200, 0x1bcf_b51a_353a_800f),
    ("UNIT", 12, 0xc482_3b9d_f16a_1df0),
];

/// Data of the simulated ULog by topic and instrument: count and digest.
#[rustfmt::skip]
pub(crate) const WRITTEN_ULOG: [(&str, u8, u64, u64); 5] = [
    ("actuator_outputs", 0, 200, 0x22c0_7b66_d6dd_e78b),
    ("airspeed", 0, 182, 0x17f1_cc8d_b84e_6608),
    ("sensor_combined", 0, 500, 0xa208_aa0a_e3c9_4a04),
    ("vehicle_air_data", 0, 182, 0xb330_2433_9dae_4332),
    ("vehicle_attitude", 0, 200, 0xba16_62c1_82e1_d570),
];
