/* Vectors for delta_test.c, made by symkin's Python solvers; numbers are exact.
 * SPDX-License-Identifier: MIT */
#ifndef DELTA_VECTORS_H
#define DELTA_VECTORS_H

#include "delta.h"

#define DELTA_VECTORS 24
#define DELTA_VECTOR_JACOBIANS 4
#define DELTA_VECTOR_SINGULAR 0
#define DELTA_VECTOR_FAR 0

static const delta_real delta_vector_guesses[24][7] = {
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.4ce5a1c3aa516p+1, -0x1.4e247db8bd764p+1, -0x1.6ef22179ea802p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.ec230c5905a90p-4, -0x1.99cdf6f876472p+1, -0x1.7d9336eb70f43p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.0418df2182139p+2, -0x1.c9ecdc62ee971p+2, -0x1.8ac179917275fp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.5838f3073b611p+1, -0x1.bb47843e8caf6p+1, -0x1.7b69f47235db1p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.22a92188582c2p+1, -0x1.d43928ade4a36p+2, -0x1.7c19a2cd0c1c5p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.e5fa40b11cae6p-1, 0x1.7f282651ddca2p-4, -0x1.9be234105d2d5p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.40682218d2b68p+0, -0x1.4696fd3db307ep+1, -0x1.6eb937919c072p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.2642e70b298e5p+1, -0x1.4ad5fc659d91fp+2, -0x1.811491c4effbdp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.58e3d7b677db3p+0, 0x1.7311224620d7bp+0, -0x1.5eececacf4bccp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.8bceaf1e21646p+2, 0x1.71f91452cf2e2p+1, -0x1.8ba9344d9d3e5p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.3b4c1c849cbcap+2, -0x1.8068685bb7757p+1, -0x1.9103dfcfd7f0dp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.f29d3f52c89c3p+1, -0x1.7837daffeeccdp-2, -0x1.5f3c999b05d03p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
};

static const delta_real delta_vector_joints[24][3] = {
    { -0x1.0e3e1bc481a4bp-4, -0x1.7df208c6781efp-7, -0x1.d0d4c18dd4698p-4 },
    { 0x1.bc804e6ef8dc2p-8, -0x1.be747a25600bep-6, -0x1.072f47ec27dbep-3 },
    { -0x1.ecca3b2214fdcp-4, 0x1.2ac6914968ffap-3, 0x1.dcf1073eb8a27p-5 },
    { -0x1.f8699e294b52ep-7, 0x1.587fbe2640dc7p-5, -0x1.1a05eafb8bfd0p-4 },
    { -0x1.e6ea19e4ad942p-5, -0x1.06238037c8c43p-3, -0x1.12e4374c9d678p-3 },
    { 0x1.79d3458cd20b0p-4, 0x1.80fd636d8da21p-4, -0x1.3025402b693a5p-3 },
    { -0x1.a1a7d59c7f272p-5, -0x1.f8ee0d8f34bbdp-4, -0x1.3b180402c3ffap-7 },
    { 0x1.213bd4c264940p-5, 0x1.f5d27f9434d5dp-7, -0x1.c1aa242b58736p-4 },
    { 0x1.f1861f6951d33p-5, 0x1.15a2438c46cacp-5, -0x1.403869d3d9309p-7 },
    { -0x1.f294a7c25148cp-5, 0x1.010fafa06c1bbp-3, -0x1.ffde9a54aa7c4p-4 },
    { -0x1.b483bd8f4227cp-4, -0x1.2a6c8564586f3p-5, -0x1.27dd949b2d179p-4 },
    { 0x1.1d98b2130d230p-5, 0x1.de231b8dfaffep-5, 0x1.f51753d99be83p-5 },
    { 0x1.508d15fd9846bp-4, -0x1.8f11c376e2b57p-4, 0x1.2eabaf45d348ep-4 },
    { -0x1.380e13bef9a57p-4, 0x1.61eb4202d9cf1p-7, -0x1.56a21060a053cp-4 },
    { 0x1.7f999b4718c34p-4, -0x1.e1d1b99b97a0ap-4, -0x1.53f1ef9c04adep-6 },
    { 0x1.48a067e9f4250p-5, 0x1.e52fcfd1640b4p-5, -0x1.f135e819596d6p-4 },
    { 0x1.297169cfa772ap-3, -0x1.0224d31e1fa5bp-4, -0x1.0782e0f070400p-6 },
    { -0x1.e1ea6b4344f93p-5, -0x1.1aafa142db46ep-3, -0x1.39eaf830fea59p-4 },
    { -0x1.a9293ebdaaf0ep-5, 0x1.717b01feddc11p-6, -0x1.08759253543afp-3 },
    { 0x1.08ade14f3ad0bp-3, -0x1.7216179979b93p-4, 0x1.21129f3ef5085p-7 },
    { -0x1.614940bbb1f25p-5, -0x1.5993f00c6cf5dp-5, 0x1.f936679b19cc6p-4 },
    { 0x1.de4ae6ae1f62ap-4, 0x1.0f538fca0cfefp-5, -0x1.0ea42ff591113p-4 },
    { -0x1.a82f512663411p-4, -0x1.54a86360f8686p-7, -0x1.95dc684b42f47p-4 },
    { -0x1.d09fc02447ddep-11, -0x1.07cf51e24ae35p-3, -0x1.28e3765c7daf6p-3 },
};

static const delta_real delta_vector_poses[24][7] = {
    { 0x1.2c255744b8d64p-3, -0x1.4ff5f22b67482p+1, -0x1.69235ef951e97p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.4cbe350581856p+1, -0x1.4dfba393b23dcp+1, -0x1.6eddc02ae4158p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.f8897e53458bfp+2, -0x1.7cf675da9a0c5p+1, -0x1.91a452dd83ba7p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.ec03dc07c72c7p-4, -0x1.999f9dd6ca648p+1, -0x1.7d7d05bc5789bp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.f22a4b1585abep+0, -0x1.1df9df3911edbp-3, -0x1.5939fe414beb3p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.03fb7844c669cp+2, -0x1.c9b92fbc5b3a9p+2, -0x1.8aaa391d6096ap+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.a0fd010a25a4bp-2, 0x1.7674858fe2bbcp+1, -0x1.6a2426aab637ep+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.58115decab75ap+1, -0x1.bb1393378338bp+1, -0x1.7b54177030aafp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.c7b0bc554343fp+0, -0x1.5b69b105b24bbp+0, -0x1.9095afeb0a67ap+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.228bd7de928bdp+1, -0x1.d40542e444fd5p+2, -0x1.7c03f376a565ep+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.8328a4e085cd7p+0, -0x1.d868e5e9f6a0bp-1, -0x1.65f145e7fce53p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.e5c73d7011cfap-1, 0x1.7f005a17f970fp-4, -0x1.9bc8bcbc3c0e8p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.a5924433ac41fp+1, 0x1.4a4f5f72c60a0p+2, -0x1.8d26a8b181c62p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.404319db1d728p+0, -0x1.4670e47408658p+1, -0x1.6ea4cf1fbf365p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.6284209065b5bp+2, 0x1.517226619550ap+1, -0x1.7dcadba4560b2p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.2620694d93b51p+1, -0x1.4ab0142867388p+2, -0x1.80fe25291ab0ap+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.b6eefc63ff890p+2, 0x1.611187803e333p+0, -0x1.8e604f8775d75p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.58b88c83b17aep+0, 0x1.72e1a52fa6961p+0, -0x1.5eda95b5b97edp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.dc4866b095070p-5, -0x1.007dcdae39b2dp+2, -0x1.6daddf5f0a4c7p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.8ba48df0e6540p+2, 0x1.71cea621da73cp+1, -0x1.8b91abdff789dp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.84dff59b448bfp+1, 0x1.4d4a58ff7226fp+2, -0x1.89dbef9cfdc99p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.3b2ab66aca492p+2, -0x1.803d78067c0f0p+1, -0x1.90ebb100160f0p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.725fbf88cd8bcp+0, -0x1.24d46fb3c20eep+1, -0x1.665d7cd3cc569p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.f260b2091e842p+1, -0x1.7805d9123d5fdp-2, -0x1.5f2a547a53f9cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
};

static const delta_real delta_vector_inverse[24][3] = {
    { -0x1.0e3e1bc481a4bp-4, -0x1.7df208c6781efp-7, -0x1.d0d4c18dd4698p-4 },
    { 0x1.bc804e6ef8dc2p-8, -0x1.be747a25600bep-6, -0x1.072f47ec27dbep-3 },
    { -0x1.ecca3b2214fdcp-4, 0x1.2ac6914968ffap-3, 0x1.dcf1073eb8a27p-5 },
    { -0x1.f8699e294b52ep-7, 0x1.587fbe2640dc7p-5, -0x1.1a05eafb8bfd0p-4 },
    { -0x1.e6ea19e4ad942p-5, -0x1.06238037c8c43p-3, -0x1.12e4374c9d678p-3 },
    { 0x1.79d3458cd20b0p-4, 0x1.80fd636d8da21p-4, -0x1.3025402b693a5p-3 },
    { -0x1.a1a7d59c7f272p-5, -0x1.f8ee0d8f34bbdp-4, -0x1.3b180402c3ffap-7 },
    { 0x1.213bd4c264940p-5, 0x1.f5d27f9434d5dp-7, -0x1.c1aa242b58736p-4 },
    { 0x1.f1861f6951d33p-5, 0x1.15a2438c46cacp-5, -0x1.403869d3d9309p-7 },
    { -0x1.f294a7c25148cp-5, 0x1.010fafa06c1bbp-3, -0x1.ffde9a54aa7c4p-4 },
    { -0x1.b483bd8f4227cp-4, -0x1.2a6c8564586f3p-5, -0x1.27dd949b2d179p-4 },
    { 0x1.1d98b2130d230p-5, 0x1.de231b8dfaffep-5, 0x1.f51753d99be83p-5 },
    { 0x1.508d15fd9846bp-4, -0x1.8f11c376e2b57p-4, 0x1.2eabaf45d348ep-4 },
    { -0x1.380e13bef9a57p-4, 0x1.61eb4202d9cf1p-7, -0x1.56a21060a053cp-4 },
    { 0x1.7f999b4718c34p-4, -0x1.e1d1b99b97a0ap-4, -0x1.53f1ef9c04adep-6 },
    { 0x1.48a067e9f4250p-5, 0x1.e52fcfd1640b4p-5, -0x1.f135e819596d6p-4 },
    { 0x1.297169cfa772ap-3, -0x1.0224d31e1fa5bp-4, -0x1.0782e0f070400p-6 },
    { -0x1.e1ea6b4344f93p-5, -0x1.1aafa142db46ep-3, -0x1.39eaf830fea59p-4 },
    { -0x1.a9293ebdaaf0ep-5, 0x1.717b01feddc11p-6, -0x1.08759253543afp-3 },
    { 0x1.08ade14f3ad0bp-3, -0x1.7216179979b93p-4, 0x1.21129f3ef5085p-7 },
    { -0x1.614940bbb1f25p-5, -0x1.5993f00c6cf5dp-5, 0x1.f936679b19cc6p-4 },
    { 0x1.de4ae6ae1f62ap-4, 0x1.0f538fca0cfefp-5, -0x1.0ea42ff591113p-4 },
    { -0x1.a82f512663411p-4, -0x1.54a86360f8686p-7, -0x1.95dc684b42f47p-4 },
    { -0x1.d09fc02447ddep-11, -0x1.07cf51e24ae35p-3, -0x1.28e3765c7daf6p-3 },
};

static const delta_real delta_vector_jacobians[4][18] = {
    { -0x1.704784b1a798cp-6, -0x1.25ff19db5b4b8p-12, -0x1.55e047091b352p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x1.5a96930cb42edp-7, -0x1.300bf46102a7cp-6, -0x1.2cbffd29b8957p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x1.86bf46c645c6ap-7, 0x1.4d0cfbd775740p-6, -0x1.7e7ae60b7361ep-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.51dbcd2a46a3dp-6, -0x1.085ef0bc9b455p-12, -0x1.1ffeb8823d06ap-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x1.5207388a5e5dfp-7, -0x1.306f6401805f7p-6, -0x1.37a8ac51c5292p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x1.7c37eab92d190p-7, 0x1.4ccbb3285333cp-6, -0x1.8a0e1203bc0bep-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.4d12d2eb74d8ap-6, -0x1.39e4b7abfc935p-12, -0x1.773c1c71eddc8p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x1.1f916f85723afp-7, -0x1.d6d5b31b0d063p-7, -0x1.ad5982e7cc38ap-8, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x1.383a028c1fa93p-7, 0x1.eeeb7a74d6bacp-7, -0x1.02fc8895fff5ep-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.486b967f7276dp-6, -0x1.3f45b5f8bd191p-12, -0x1.2eb7cabc643a6p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x1.35f51381abd5fp-7, -0x1.10d3c87227c34p-6, -0x1.0a6cd9c9bfba0p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x1.5c49528983afap-7, 0x1.27fe52052464ep-6, -0x1.54a1845ffbb22p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
};

static const delta_real delta_vector_home[7] = { 0x0.0p+0, 0x0.0p+0, -0x1.836fa1ac4a91cp+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 };
static const delta_real delta_vector_far[7] = { 0x1.e5c73d7011cfap-1, 0x1.7f005a17f970fp-4, -0x1.9bc8bcbc3c0e8p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 };

/* Error allowed, as a length. */
static const double delta_vector_bounds[24] = { 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09, 2e-09 };

#endif
