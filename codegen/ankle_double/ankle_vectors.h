/* Vectors for ankle_test.c, made by symkin's Python solvers; numbers are exact.
 * SPDX-License-Identifier: MIT */
#ifndef ANKLE_VECTORS_H
#define ANKLE_VECTORS_H

#include "ankle.h"

#define ANKLE_VECTORS 24
#define ANKLE_VECTOR_JACOBIANS 4

static const ankle_real ankle_vector_joints[24][2] = {
    { -0x1.0e3e1bc481a4bp-3, -0x1.7df208c6781efp-6 },
    { -0x1.d0d4c18dd4698p-3, 0x1.bc804e6ef8dc2p-7 },
    { -0x1.be747a25600bep-5, -0x1.072f47ec27dbep-2 },
    { -0x1.ecca3b2214fdcp-3, 0x1.2ac6914968ffap-2 },
    { 0x1.dcf1073eb8a27p-4, -0x1.f8699e294b52ep-6 },
    { 0x1.587fbe2640dc7p-4, -0x1.1a05eafb8bfd0p-3 },
    { -0x1.e6ea19e4ad942p-4, -0x1.06238037c8c43p-2 },
    { -0x1.12e4374c9d678p-2, 0x1.79d3458cd20b0p-3 },
    { 0x1.80fd636d8da21p-3, -0x1.3025402b693a5p-2 },
    { -0x1.a1a7d59c7f272p-4, -0x1.f8ee0d8f34bbdp-3 },
    { -0x1.3b180402c3ffap-6, 0x1.213bd4c264940p-4 },
    { 0x1.f5d27f9434d5dp-6, -0x1.c1aa242b58736p-3 },
    { 0x1.f1861f6951d33p-4, 0x1.15a2438c46cacp-4 },
    { -0x1.403869d3d9309p-6, -0x1.f294a7c25148cp-4 },
    { 0x1.010fafa06c1bbp-2, -0x1.ffde9a54aa7c4p-3 },
    { -0x1.b483bd8f4227cp-3, -0x1.2a6c8564586f3p-4 },
    { -0x1.27dd949b2d179p-3, 0x1.1d98b2130d230p-4 },
    { 0x1.de231b8dfaffep-4, 0x1.f51753d99be83p-4 },
    { 0x1.508d15fd9846bp-3, -0x1.8f11c376e2b57p-3 },
    { 0x1.2eabaf45d348ep-3, -0x1.380e13bef9a57p-3 },
    { 0x1.61eb4202d9cf1p-6, -0x1.56a21060a053cp-3 },
    { 0x1.7f999b4718c34p-3, -0x1.e1d1b99b97a0ap-3 },
    { -0x1.53f1ef9c04adep-5, 0x1.48a067e9f4250p-4 },
    { 0x1.e52fcfd1640b4p-4, -0x1.f135e819596d6p-3 },
};

static const ankle_real ankle_vector_found[24][2] = {
    { -0x1.13da2b40caa09p-4, -0x1.268dc55c87d79p-4 },
    { -0x1.67b8f16d8a48dp-4, -0x1.47a776fc5a1cdp-3 },
    { -0x1.0f04503c42c5dp-3, 0x1.12f819a806316p-3 },
    { 0x1.93bcd4ba4f72dp-5, -0x1.6ab9865f9d96dp-2 },
    { 0x1.4857ac710a1d2p-5, 0x1.88fb320e5526cp-4 },
    { -0x1.42bab0821a82ap-6, 0x1.2a67a104ce153p-3 },
    { -0x1.4abd5695e125ep-3, 0x1.743ab4bdc2f83p-4 },
    { -0x1.155864baada35p-6, -0x1.351ce60af575fp-2 },
    { -0x1.b589d8f371295p-6, 0x1.49b603878ffc3p-2 },
    { -0x1.336764429ca3ap-3, 0x1.886342d23f938p-4 },
    { 0x1.86ae4ace81a1ap-6, -0x1.e040b44bc351dp-5 },
    { -0x1.3dc4117cb3a5fp-4, 0x1.52b253edf8986p-3 },
    { 0x1.5f4031710f1c6p-4, 0x1.1d7adc73d434dp-5 },
    { -0x1.f927d015adf2fp-5, 0x1.13629a6c6930cp-4 },
    { 0x1.6c71d7f4f92fcp-6, 0x1.533e31ccb34eep-2 },
    { -0x1.f835869d0329bp-4, -0x1.7f2a3aeac73d6p-4 },
    { -0x1.d540638892e50p-6, -0x1.216688760ae82p-3 },
    { 0x1.bc789b19589d2p-4, -0x1.c2e5716f71f04p-9 },
    { -0x1.454e0f6d001fep-9, 0x1.e457d192a85e6p-3 },
    { 0x1.69167bd1a891dp-8, 0x1.9388e60df093ap-3 },
    { -0x1.f64c66f2d9c6fp-5, 0x1.fe0028cbc423ep-4 },
    { -0x1.70afab80ab655p-8, 0x1.1dc7f32c7d0d3p-2 },
    { 0x1.33f8e42222cc8p-6, -0x1.45ddcaf710063p-4 },
    { -0x1.61e7078ea0324p-5, 0x1.e928341e641cfp-3 },
};

static const ankle_real ankle_vector_guesses[24][2] = {
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.6704151792ca5p-4, -0x1.47a5ccd705758p-3 },
    { 0x0.0p+0, 0x0.0p+0 },
    { 0x1.95295993557c1p-5, -0x1.6ab78b092eb04p-2 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.3fd6cabfb0807p-6, 0x1.2a6633223b0b1p-3 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.1284d53ef5f99p-6, -0x1.351b5e715cd80p-2 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.330e3fb016c59p-3, 0x1.88626ef6ed498p-4 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.3d0ea5dcfc716p-4, 0x1.52b108f88d984p-3 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.f7b88014f280fp-5, 0x1.1361a2d845c7cp-4 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.f781adfec81ebp-4, -0x1.7f282e8124d1dp-4 },
    { 0x0.0p+0, 0x0.0p+0 },
    { 0x1.bd3a0cbde7635p-4, -0x1.c2da0cf55a154p-9 },
    { 0x0.0p+0, 0x0.0p+0 },
    { 0x1.74aaa9be802ffp-8, 0x1.9386d50b2daf8p-3 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.654a3c264d527p-8, 0x1.1dc6a21d4f79cp-2 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.607be22cb3451p-5, 0x1.e92626e8b1b26p-3 },
};

static const ankle_real ankle_vector_joint_guesses[24][2] = {
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.d06be60227f87p-3, 0x1.c30e0729bfecfp-7 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.ec615f96688cbp-3, 0x1.2afaff0f3f382p-2 },
    { 0x0.0p+0, 0x0.0p+0 },
    { 0x1.5951753d99be8p-4, -0x1.199d0f6fdf8bfp-3 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.12afc986c72f0p-2, 0x1.7a3c21187e7c0p-3 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.a0d61e8526451p-4, -0x1.f8853203884acp-3 },
    { 0x0.0p+0, 0x0.0p+0 },
    { 0x1.f9195bf1985e3p-6, -0x1.c141489fac025p-3 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.3cf18d7675a82p-6, -0x1.f1c2f0aaf866bp-4 },
    { 0x0.0p+0, 0x0.0p+0 },
    { -0x1.b41ae20395b6bp-3, -0x1.299ace4cff8d1p-4 },
    { 0x0.0p+0, 0x0.0p+0 },
    { 0x1.def4d2a553e20p-4, 0x1.f5e90af0f4ca4p-4 },
    { 0x0.0p+0, 0x0.0p+0 },
    { 0x1.2f148ad17fb9fp-3, -0x1.37a538334d346p-3 },
    { 0x0.0p+0, 0x0.0p+0 },
    { 0x1.800276d2c5345p-3, -0x1.e168de0feb2f9p-3 },
    { 0x0.0p+0, 0x0.0p+0 },
    { 0x1.e60186e8bced6p-4, -0x1.f0cd0c8dacfc5p-3 },
};

static const ankle_real ankle_vector_inverse[24][2] = {
    { -0x1.0e3e1bc481a4bp-3, -0x1.7df208c6781efp-6 },
    { -0x1.d0d4c18dd54aap-3, 0x1.bc804e6ef8dc2p-7 },
    { -0x1.be747a25600bep-5, -0x1.072f47ec27dbep-2 },
    { -0x1.ecca3b2214fdcp-3, 0x1.2ac6914968ffap-2 },
    { 0x1.dcf1073eb6e01p-4, -0x1.f8699e294b52ep-6 },
    { 0x1.587fbe2640dc7p-4, -0x1.1a05eafb8bfd0p-3 },
    { -0x1.e6ea19e4abd1cp-4, -0x1.06238037c8c43p-2 },
    { -0x1.12e4374c9d678p-2, 0x1.79d3458cd129dp-3 },
    { 0x1.80fd636d8da21p-3, -0x1.3025402b693a5p-2 },
    { -0x1.a1a7d59c7d64dp-4, -0x1.f8ee0d8f34bbdp-3 },
    { -0x1.3b180402c3ffap-6, 0x1.213bd4c262d1ap-4 },
    { 0x1.f5d27f9434d5dp-6, -0x1.c1aa242b58736p-3 },
    { 0x1.f1861f6951d33p-4, 0x1.15a2438c488d2p-4 },
    { -0x1.403869d3d9309p-6, -0x1.f294a7c25148cp-4 },
    { 0x1.010fafa06c1bbp-2, -0x1.ffde9a54aa7c4p-3 },
    { -0x1.b483bd8f4227cp-3, -0x1.2a6c8564586f3p-4 },
    { -0x1.27dd949b2d179p-3, 0x1.1d98b2130d230p-4 },
    { 0x1.de231b8dfaffep-4, 0x1.f51753d99be83p-4 },
    { 0x1.508d15fd9846bp-3, -0x1.8f11c376e2b57p-3 },
    { 0x1.2eabaf45d348ep-3, -0x1.380e13bef9a57p-3 },
    { 0x1.61eb4202d9cf1p-6, -0x1.56a21060a053cp-3 },
    { 0x1.7f999b4718c34p-3, -0x1.e1d1b99b97a0ap-3 },
    { -0x1.53f1ef9c04adep-5, 0x1.48a067e9f4250p-4 },
    { 0x1.e52fcfd1640b4p-4, -0x1.f135e819596d6p-3 },
};

static const ankle_real ankle_vector_jacobians[4][4] = {
    { 0x1.a858fcc664a8dp-2, 0x1.d66eac052c0edp-2, 0x1.551ec84aba96fp-1, -0x1.50805d328b17ap-1 },
    { 0x1.862817d4bb8c4p-2, 0x1.eceda92a1f272p-2, 0x1.5a75103c27118p-1, -0x1.5254c361fb2dfp-1 },
    { 0x1.de19f2a2fdcf0p-2, 0x1.8b15153263a1ep-2, 0x1.53176f884e17cp-1, -0x1.56c213f2616d1p-1 },
    { 0x1.53f2f12c5b306p-2, 0x1.12fbf493cc615p-1, 0x1.6bd635926f3f1p-1, -0x1.587cd8bb0f01ap-1 },
};

#define ANKLE_VECTOR_INFEASIBLE_JOINTS 4
static const ankle_real ankle_vector_infeasible_joints[4][2] = {
    { 0x1.8bcacf9c8ae5ap-1, 0x1.0379009cddf1cp+0 },
    { 0x1.de383c876fcb7p+0, 0x1.fa0837dce61f8p+0 },
    { -0x1.1d0d4c18dd469p+1, 0x1.01bc804e6ef8ep+1 },
    { 0x1.c266b89bbd605p+0, 0x1.2558d2292d1ffp+1 },
};

#define ANKLE_VECTOR_PAST_JOINTS 0
static const ankle_real ankle_vector_past_joints[1][2] = {
    { 0x0.0p+0, 0x0.0p+0 },
};

#define ANKLE_VECTOR_INFEASIBLE_FOUND 4
static const ankle_real ankle_vector_infeasible_found[4][2] = {
    { -0x1.113da2b405bccp+0, -0x1.1268dc55897cfp+0 },
    { 0x1.d308e1d0eae9ap-1, 0x1.ae162245131e6p-1 },
    { -0x1.0b3dc78bc545ap+1, 0x1.d70b1122898f3p+0 },
    { -0x1.10f04503e2851p+1, -0x1.dda0fccb7e545p+0 },
};

#define ANKLE_VECTOR_PAST_FOUND 0
static const ankle_real ankle_vector_past_found[1][2] = {
    { 0x0.0p+0, 0x0.0p+0 },
};

static const ankle_real ankle_vector_home_joints[2] = { 0x0.0p+0, 0x0.0p+0 };
static const ankle_real ankle_vector_home_found[2] = { 0x0.0p+0, 0x0.0p+0 };

/* Error allowed, as a length. */
static const double ankle_vector_bounds[24] = { 1.7e-09, 1.7e-09, 1.7e-09, 1.8e-09, 1.6e-09,
    1.6e-09, 1.7e-09, 1.7e-09, 1.7e-09, 1.7e-09, 1.7e-09, 1.7e-09, 1.6e-09, 1.7e-09, 1.6e-09,
    1.7e-09, 1.7e-09, 1.6e-09, 1.6e-09, 1.6e-09, 1.7e-09, 1.7e-09, 1.7e-09, 1.7e-09 };

#endif
