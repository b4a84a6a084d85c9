/* Vectors for ankle_test.c, made by symkin's Python solvers; numbers are exact.
 * SPDX-License-Identifier: MIT */
#ifndef ANKLE_VECTORS_H
#define ANKLE_VECTORS_H

#include "ankle.h"

#define ANKLE_VECTORS 24
#define ANKLE_VECTOR_JACOBIANS 4

static const ankle_real ankle_vector_joints[24][2] = {
    { -0x1.0e3e1c0000000p-3f, -0x1.7df2080000000p-6f },
    { -0x1.d0d4c20000000p-3f, 0x1.bc804e0000000p-7f },
    { -0x1.be747a0000000p-5f, -0x1.072f480000000p-2f },
    { -0x1.ecca3c0000000p-3f, 0x1.2ac6920000000p-2f },
    { 0x1.dcf1080000000p-4f, -0x1.f8699e0000000p-6f },
    { 0x1.587fbe0000000p-4f, -0x1.1a05ea0000000p-3f },
    { -0x1.e6ea1a0000000p-4f, -0x1.0623800000000p-2f },
    { -0x1.12e4380000000p-2f, 0x1.79d3460000000p-3f },
    { 0x1.80fd640000000p-3f, -0x1.3025400000000p-2f },
    { -0x1.a1a7d60000000p-4f, -0x1.f8ee0e0000000p-3f },
    { -0x1.3b18040000000p-6f, 0x1.213bd40000000p-4f },
    { 0x1.f5d2800000000p-6f, -0x1.c1aa240000000p-3f },
    { 0x1.f186200000000p-4f, 0x1.15a2440000000p-4f },
    { -0x1.40386a0000000p-6f, -0x1.f294a80000000p-4f },
    { 0x1.010fb00000000p-2f, -0x1.ffde9a0000000p-3f },
    { -0x1.b483be0000000p-3f, -0x1.2a6c860000000p-4f },
    { -0x1.27dd940000000p-3f, 0x1.1d98b20000000p-4f },
    { 0x1.de231c0000000p-4f, 0x1.f517540000000p-4f },
    { 0x1.508d160000000p-3f, -0x1.8f11c40000000p-3f },
    { 0x1.2eabb00000000p-3f, -0x1.380e140000000p-3f },
    { 0x1.61eb420000000p-6f, -0x1.56a2100000000p-3f },
    { 0x1.7f999c0000000p-3f, -0x1.e1d1ba0000000p-3f },
    { -0x1.53f1f00000000p-5f, 0x1.48a0680000000p-4f },
    { 0x1.e52fd00000000p-4f, -0x1.f135e80000000p-3f },
};

static const ankle_real ankle_vector_found[24][2] = {
    { -0x1.13da2c0000000p-4f, -0x1.268dc60000000p-4f },
    { -0x1.67b8f20000000p-4f, -0x1.47a7780000000p-3f },
    { -0x1.0f04500000000p-3f, 0x1.12f81a0000000p-3f },
    { 0x1.93bcd60000000p-5f, -0x1.6ab9880000000p-2f },
    { 0x1.4857ae0000000p-5f, 0x1.88fb320000000p-4f },
    { -0x1.42baae0000000p-6f, 0x1.2a67a00000000p-3f },
    { -0x1.4abd560000000p-3f, 0x1.743ab40000000p-4f },
    { -0x1.1558660000000p-6f, -0x1.351ce60000000p-2f },
    { -0x1.b589d60000000p-6f, 0x1.49b6040000000p-2f },
    { -0x1.3367640000000p-3f, 0x1.8863440000000p-4f },
    { 0x1.86ae4a0000000p-6f, -0x1.e040b40000000p-5f },
    { -0x1.3dc4120000000p-4f, 0x1.52b2540000000p-3f },
    { 0x1.5f40320000000p-4f, 0x1.1d7adc0000000p-5f },
    { -0x1.f927d00000000p-5f, 0x1.13629a0000000p-4f },
    { 0x1.6c71dc0000000p-6f, 0x1.533e320000000p-2f },
    { -0x1.f835880000000p-4f, -0x1.7f2a3c0000000p-4f },
    { -0x1.d540620000000p-6f, -0x1.2166880000000p-3f },
    { 0x1.bc789c0000000p-4f, -0x1.c2e56c0000000p-9f },
    { -0x1.454e1c0000000p-9f, 0x1.e457d20000000p-3f },
    { 0x1.6916840000000p-8f, 0x1.9388e60000000p-3f },
    { -0x1.f64c660000000p-5f, 0x1.fe00280000000p-4f },
    { -0x1.70afa40000000p-8f, 0x1.1dc7f40000000p-2f },
    { 0x1.33f8e40000000p-6f, -0x1.45ddcc0000000p-4f },
    { -0x1.61e7080000000p-5f, 0x1.e928340000000p-3f },
};

static const ankle_real ankle_vector_guesses[24][2] = {
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.6704160000000p-4f, -0x1.47a5ce0000000p-3f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { 0x1.95295c0000000p-5f, -0x1.6ab78c0000000p-2f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.3fd6c80000000p-6f, 0x1.2a66320000000p-3f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.1284d80000000p-6f, -0x1.351b600000000p-2f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.330e400000000p-3f, 0x1.8862700000000p-4f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.3d0ea60000000p-4f, 0x1.52b1080000000p-3f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.f7b8800000000p-5f, 0x1.1361a20000000p-4f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.f781ae0000000p-4f, -0x1.7f282e0000000p-4f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { 0x1.bd3a0e0000000p-4f, -0x1.c2da060000000p-9f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { 0x1.74aab20000000p-8f, 0x1.9386d60000000p-3f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.654a340000000p-8f, 0x1.1dc6a20000000p-2f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.607be20000000p-5f, 0x1.e926260000000p-3f },
};

static const ankle_real ankle_vector_joint_guesses[24][2] = {
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.d06be60000000p-3f, 0x1.c30e060000000p-7f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.ec61600000000p-3f, 0x1.2afb000000000p-2f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { 0x1.5951760000000p-4f, -0x1.199d0e0000000p-3f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.12afca0000000p-2f, 0x1.7a3c220000000p-3f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.a0d61e0000000p-4f, -0x1.f885320000000p-3f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { 0x1.f9195c0000000p-6f, -0x1.c141480000000p-3f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.3cf18e0000000p-6f, -0x1.f1c2f00000000p-4f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { -0x1.b41ae20000000p-3f, -0x1.299ace0000000p-4f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { 0x1.def4d40000000p-4f, 0x1.f5e90c0000000p-4f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { 0x1.2f148c0000000p-3f, -0x1.37a5380000000p-3f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { 0x1.8002780000000p-3f, -0x1.e168de0000000p-3f },
    { 0x0.0p+0f, 0x0.0p+0f },
    { 0x1.e601880000000p-4f, -0x1.f0cd0c0000000p-3f },
};

static const ankle_real ankle_vector_inverse[24][2] = {
    { -0x1.0e3e1c0000000p-3f, -0x1.7df20a0000000p-6f },
    { -0x1.d0d4c20000000p-3f, 0x1.bc80540000000p-7f },
    { -0x1.be74780000000p-5f, -0x1.072f480000000p-2f },
    { -0x1.ecca3e0000000p-3f, 0x1.2ac6920000000p-2f },
    { 0x1.dcf1080000000p-4f, -0x1.f8699a0000000p-6f },
    { 0x1.587fbe0000000p-4f, -0x1.1a05ea0000000p-3f },
    { -0x1.e6ea1a0000000p-4f, -0x1.0623800000000p-2f },
    { -0x1.12e4380000000p-2f, 0x1.79d3460000000p-3f },
    { 0x1.80fd640000000p-3f, -0x1.3025400000000p-2f },
    { -0x1.a1a7d40000000p-4f, -0x1.f8ee0e0000000p-3f },
    { -0x1.3b18040000000p-6f, 0x1.213bd40000000p-4f },
    { 0x1.f5d27e0000000p-6f, -0x1.c1aa240000000p-3f },
    { 0x1.f186200000000p-4f, 0x1.15a2440000000p-4f },
    { -0x1.40386a0000000p-6f, -0x1.f294a80000000p-4f },
    { 0x1.010fb00000000p-2f, -0x1.ffde9a0000000p-3f },
    { -0x1.b483be0000000p-3f, -0x1.2a6c860000000p-4f },
    { -0x1.27dd940000000p-3f, 0x1.1d98b20000000p-4f },
    { 0x1.de231c0000000p-4f, 0x1.f517540000000p-4f },
    { 0x1.508d160000000p-3f, -0x1.8f11c40000000p-3f },
    { 0x1.2eabb00000000p-3f, -0x1.380e140000000p-3f },
    { 0x1.61eb420000000p-6f, -0x1.56a2100000000p-3f },
    { 0x1.7f999c0000000p-3f, -0x1.e1d1ba0000000p-3f },
    { -0x1.53f1f20000000p-5f, 0x1.48a0680000000p-4f },
    { 0x1.e52fd00000000p-4f, -0x1.f135e80000000p-3f },
};

static const ankle_real ankle_vector_jacobians[4][4] = {
    { 0x1.a858fc0000000p-2f, 0x1.d66eac0000000p-2f, 0x1.551ec80000000p-1f, -0x1.50805e0000000p-1f },
    { 0x1.8628180000000p-2f, 0x1.ecedaa0000000p-2f, 0x1.5a75100000000p-1f, -0x1.5254c40000000p-1f },
    { 0x1.de19f20000000p-2f, 0x1.8b15160000000p-2f, 0x1.5317700000000p-1f, -0x1.56c2140000000p-1f },
    { 0x1.53f2f00000000p-2f, 0x1.12fbf40000000p-1f, 0x1.6bd6360000000p-1f, -0x1.587cd80000000p-1f },
};

#define ANKLE_VECTOR_INFEASIBLE_JOINTS 4
static const ankle_real ankle_vector_infeasible_joints[4][2] = {
    { 0x1.8bcad00000000p-1f, 0x1.0379000000000p+0f },
    { 0x1.de383c0000000p+0f, 0x1.fa08380000000p+0f },
    { -0x1.1d0d4c0000000p+1f, 0x1.01bc800000000p+1f },
    { 0x1.c266b80000000p+0f, 0x1.2558d20000000p+1f },
};

#define ANKLE_VECTOR_PAST_JOINTS 0
static const ankle_real ankle_vector_past_joints[1][2] = {
    { 0x0.0p+0f, 0x0.0p+0f },
};

#define ANKLE_VECTOR_INFEASIBLE_FOUND 4
static const ankle_real ankle_vector_infeasible_found[4][2] = {
    { -0x1.113da20000000p+0f, -0x1.1268dc0000000p+0f },
    { 0x1.d308e20000000p-1f, 0x1.ae16220000000p-1f },
    { -0x1.0b3dc80000000p+1f, 0x1.d70b120000000p+0f },
    { -0x1.10f0460000000p+1f, -0x1.dda0fc0000000p+0f },
};

#define ANKLE_VECTOR_PAST_FOUND 0
static const ankle_real ankle_vector_past_found[1][2] = {
    { 0x0.0p+0f, 0x0.0p+0f },
};

static const ankle_real ankle_vector_home_joints[2] = { 0x0.0p+0f, 0x0.0p+0f };
static const ankle_real ankle_vector_home_found[2] = { 0x0.0p+0f, 0x0.0p+0f };

/* Error allowed, as a length. */
static const double ankle_vector_bounds[24] = { 0.00081, 0.00082, 0.00081, 0.00085, 0.00079,
    0.0008, 0.00081, 0.00084, 0.0008, 0.00081, 0.0008, 0.0008, 0.00079, 0.0008, 0.0008, 0.00082,
    0.00081, 0.00079, 0.00079, 0.00079, 0.0008, 0.0008, 0.00081, 0.0008 };

#endif
