/* Vectors for scara_test.c, made by symkin's Python solvers; numbers are exact.
 * SPDX-License-Identifier: MIT */
#ifndef SCARA_VECTORS_H
#define SCARA_VECTORS_H

#include "scara.h"

#define SCARA_VECTORS 24
#define SCARA_VECTOR_JACOBIANS 4
#define SCARA_VECTOR_SINGULAR 1
#define SCARA_VECTOR_INFEASIBLE 0
#define SCARA_VECTOR_PAST 6
#define SCARA_VECTOR_FAR 1

static const scara_real scara_vector_guesses[24][4] = {
    { 0x1.9552e2fbe33adp-3, -0x1.9f9378ee28672p-4, 0x1.def2c7325918ap-2, -0x1.a08de00d1b717p+6 },
    { 0x1.5f5ea67e846a6p-1, 0x1.b022dd7a99fa1p-4, 0x1.2a7cbf6e3f78cp-1, -0x1.2dce12e83a10ap+6 },
    { -0x1.9ec7000431bdfp-7, 0x1.9de9c0229a5ecp-2, 0x1.b0da7f3cf7015p-1, -0x1.4f52962cfd8f1p+6 },
    { 0x1.63a647fdc5932p-1, 0x1.3f2dc2b0ea183p-1, -0x1.b30ec31162281p-2, -0x1.0e46030c23fabp+6 },
    { 0x1.43a604e1e7104p-2, 0x1.7aba5a038194cp-1, 0x1.032fcac8e68e4p-2, -0x1.b14e0daa0cae6p+6 },
    { -0x1.04289118c197ep-2, -0x1.01ecd4aa10e02p-1, 0x1.79f01b866e43bp-4, -0x1.08d65cb35f3d8p+6 },
    { 0x1.7ea1a500d5e8dp-1, 0x1.0bb01c92ddbdbp-3, -0x1.71b089a027525p-2, -0x1.4c5e6ddf00abfp+5 },
    { -0x1.298aa8650e779p-4, 0x1.b8cb07d0aed9ap-3, -0x1.48fd9fd36f7e4p-7, -0x1.8dbae3e6c4c59p+6 },
    { 0x1.affa7eb6bf445p-3, 0x1.7c73eee525892p-2, -0x1.a45996744b2b7p-2, -0x1.320d606317269p+6 },
    { -0x1.a3ee1bd1ed9e0p-3, -0x1.17cfa26a22b39p-1, -0x1.876d117b5286bp-2, -0x1.3f26c332f0175p+5 },
    { 0x1.4861c79b34a45p-1, -0x1.24cb5bb384fd3p-2, 0x1.a63065f9591cdp-2, -0x1.af72c6ac215bap+6 },
    { -0x1.d4057082491b0p-4, -0x1.5ba7fc32ebe59p-2, 0x1.5109d0635a427p-1, -0x1.4f7e8d972cd7dp+6 },
    { -0x1.0b524399b2c41p-5, 0x1.9cb2314013ec4p-1, 0x1.50eae18ac9f30p-1, -0x1.4866a619da9cap+6 },
    { -0x1.98f190d173fb8p-2, 0x1.b4784230fcf81p-2, -0x1.4dc55000c953ap-1, -0x1.4a68fffbce421p+6 },
    { 0x1.4e20ccff21b3bp-1, 0x1.5dc853c148345p-1, -0x1.e1d4738a3b57cp-2, -0x1.bd10e8858ff76p+6 },
    { 0x1.c75b3e1437c57p-2, 0x1.2b0c026cc1ca4p-3, -0x1.78d716d2aa5c6p-2, -0x1.1d893faf42785p+6 },
    { -0x1.3ff3061c79b35p-1, 0x1.f4690de093533p-3, 0x1.9a6e75ff609ddp-4, -0x1.f40f0ae536502p+5 },
    { -0x1.76ba493c89f41p-1, 0x1.16634117f8445p-2, -0x1.f1ac9afe1da7bp-3, -0x1.21c0fc2eba27bp+6 },
    { -0x1.cde97d06bbdbep-3, 0x1.f0d49949e8816p-3, 0x1.08e25c810a56ap-3, -0x1.f29c5c5718eb9p+5 },
    { -0x1.43aa582dbe7f3p-1, -0x1.115a4acf312b2p-1, -0x1.2d0f40e5a35d6p-1, -0x1.538b3edd8b60fp+6 },
    { -0x1.23fcc9ea9a3d3p-4, -0x1.17bdad7518b0dp-1, 0x1.6863beec3979ap-2, -0x1.2750f4d7add16p+6 },
    { 0x1.6c82e019b0ab3p-5, 0x1.db3e1437c5693p-5, 0x1.4d5f99c38b04bp-1, -0x1.05937d63022ddp+6 },
    { -0x1.19fb6134ce3dep-1, -0x1.38114d2f5dbbap-1, 0x1.731c219eb6391p-2, -0x1.712563ed0f627p+6 },
    { -0x1.f98a222d5171ep-2, -0x1.6634117f8444ap-2, -0x1.2e846a5d6bebep-2, -0x1.4bf31c219eb64p+6 },
};

static const scara_real scara_vector_joints[24][4] = {
    { 0x1.5fc86cebbba56p-3, -0x1.94ba51a005c46p-3, 0x1.eea28fe260b2dp-2, -0x1.9426ae7d566cfp+6 },
    { 0x1.307182235b4eep-1, 0x1.1ff92f2b66b61p-4, 0x1.497e996312f4dp-1, -0x1.334f954eb13e0p+6 },
    { -0x1.c77ff151e7536p-4, 0x1.d9691a75cd0bbp-2, 0x1.8c9e44fa05144p-1, -0x1.55b01040bfe3bp+6 },
    { 0x1.80266772d5e07p-1, 0x1.5f75536933a04p-1, -0x1.0808c8259e1f4p-1, -0x1.092ae03b3e9a7p+6 },
    { 0x1.4fa69be09bb6bp-2, 0x1.6abead4f5903ap-1, 0x1.0f69ca9ef5233p-2, -0x1.a150385c67dfep+6 },
    { -0x1.ebb98c7e28241p-3, -0x1.c492bc2fc6973p-2, 0x1.217f4128bf3bfp-5, -0x1.fda68e3ef2841p+5 },
    { 0x1.67b762d83c6c9p-1, 0x1.0cbfb15b573ebp-3, -0x1.7c61d8622c450p-2, -0x1.44f1b69121251p+5 },
    { -0x1.b1d92b7fe08afp-7, 0x1.2008205ff1d82p-2, -0x1.3a109d0635a42p-5, -0x1.8690ff10ecb75p+6 },
    { 0x1.3b7a1c25d0742p-2, 0x1.bb66b6177ea1cp-2, -0x1.fa9c99285a922p-2, -0x1.38d3ae2541d8fp+6 },
    { -0x1.c4cdfaca36199p-3, -0x1.0dbcec84f8f8ap-1, -0x1.c8897e996312fp-2, -0x1.2ffec918e325dp+5 },
    { 0x1.3ac16df3f9618p-1, -0x1.81b4bb5e0f7fdp-3, 0x1.885a4f00ef135p-2, -0x1.be91fa7653437p+6 },
    { -0x1.95eaee2003ab8p-3, -0x1.f1ee2435696e6p-3, 0x1.8305b7cfe5860p-1, -0x1.4292a5614df8bp+6 },
    { -0x1.01f31f46ed246p-11, 0x1.7589acbc8c0cfp-1, 0x1.4a4c404a72eaep-1, -0x1.4d98bd230b9dcp+6 },
    { -0x1.3b9fdbd2fa0d7p-2, 0x1.f71151611ba3dp-2, -0x1.418f1d3ed527ep-1, -0x1.4e7fe260b2c84p+6 },
    { 0x1.345fe111276fbp-1, 0x1.5621fafc8b008p-1, -0x1.b4ac29bf162aep-2, -0x1.b2cf3eccc4695p+6 },
    { 0x1.d769a91105e1cp-2, 0x1.8f0ae536501e2p-3, -0x1.ae12620253975p-2, -0x1.2a1d3aa369fcfp+6 },
    { -0x1.5f182235b4edbp-1, 0x1.47d2c7b890d5ap-2, 0x1.5e4c51116a8b9p-5, -0x1.d5067e846a5d7p+5 },
    { -0x1.515f2452c59fbp-1, 0x1.da87a072d1aebp-3, -0x1.a8e25c810a56ap-3, -0x1.2c38a47ecfe9bp+6 },
    { -0x1.0d8ba40d90e24p-2, 0x1.b75fb2edfe75cp-3, 0x1.bf5a5332acfb7p-4, -0x1.0685f56a7ac82p+6 },
    { -0x1.65adfb506dd6ap-1, -0x1.c253da72a7bd5p-2, -0x1.5eb228dc981bfp-1, -0x1.51583d790752ep+6 },
    { -0x1.f1d81f10667f9p-6, -0x1.3d91cd1c7de51p-1, 0x1.1294141e9af5cp-2, -0x1.300bbbe878facp+6 },
    { 0x1.14d2f5dbb9cfap-11, 0x1.3f601797cc3a0p-3, 0x1.64408d8ec95c0p-1, -0x1.0f902ea960b70p+6 },
    { -0x1.4d04e618ce2d2p-1, -0x1.219cbee807bbbp-1, 0x1.3dacabc515486p-2, -0x1.64c332acfb763p+6 },
    { -0x1.03b3c81908e58p-1, -0x1.60902de00d1b7p-2, -0x1.54e26d4801f75p-2, -0x1.471925785f8d3p+6 },
};

static const scara_real scara_vector_poses[24][7] = {
    { 0x1.8ca162a6b31a9p+8, 0x1.0f7a2f0e22920p+5, -0x1.9426ae7d566cfp+6, 0x1.f2ae425be5566p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.d01889142b0c9p-3 },
    { 0x1.4419c693aa6fcp+8, 0x1.d408f7b733c2dp+7, -0x1.334f954eb13e0p+6, 0x1.9647966bee1e5p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.3793f85164862p-1 },
    { 0x1.83ef0a08985a2p+8, 0x1.19c1b25c6f52ep+5, -0x1.55b01040bfe3bp+6, 0x1.b102a7c7980fdp-1,
        0x0.0p+0, 0x0.0p+0, 0x1.1136d7fc37477p-1 },
    { 0x1.77f37e359ce75p+7, 0x1.46d8c26866d10p+8, -0x1.092ae03b3e9a7p+6, 0x1.caa90805a62a3p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.c714d079662d2p-2 },
    { 0x1.2e2be31c57d81p+8, 0x1.be0ddaff12e5dp+7, -0x1.a150385c67dfep+6, 0x1.9763d7217138cp-1,
        0x0.0p+0, 0x0.0p+0, 0x1.361ff262ab8cdp-1 },
    { 0x1.6264aead42fffp+8, -0x1.47a634c55ddc7p+7, -0x1.fda68e3ef2841p+5, 0x1.e576cd19dfba8p-1,
        0x0.0p+0, 0x0.0p+0, -0x1.45623ac4e4567p-2 },
    { 0x1.215415fba4579p+8, 0x1.12f9f02563712p+8, -0x1.44f1b69121251p+5, 0x1.f26184aad6345p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.d5384127d3c29p-3 },
    { 0x1.89bb36c8b2819p+8, 0x1.5af2e197078ebp+5, -0x1.8690ff10ecb75p+6, 0x1.fca07922afdb3p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.d565efeb94db7p-4 },
    { 0x1.578261b156ecdp+8, 0x1.74bccb2afe5edp+7, -0x1.38d3ae2541d8fp+6, 0x1.fc1ee82662443p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.f74213dcb69c2p-4 },
    { 0x1.5bd0bf3c7ebf0p+8, -0x1.50ba1dd0780c8p+7, -0x1.2ffec918e325dp+5, 0x1.a778960e1a8efp-1,
        0x0.0p+0, 0x0.0p+0, -0x1.1fc7368a7eca8p-1 },
    { 0x1.57226a1cd74dcp+8, 0x1.944ee65410dc1p+7, -0x1.be91fa7653437p+6, 0x1.d69f680679690p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.93472ce155de8p-2 },
    { 0x1.7ad3bd70485b7p+8, -0x1.dc3794fbe827dp+6, -0x1.4292a5614df8bp+6, 0x1.f9ae0ff2904c2p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.40cb50e4bc64fp-3 },
    { 0x1.638374f6c162cp+8, 0x1.d1e1fa186d30cp+6, -0x1.4d98bd230b9dcp+6, 0x1.8bd2d377a6e28p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.44c208fb12b83p-1 },
    { 0x1.827902e5116e1p+8, -0x1.233962cb11bbep+5, -0x1.4e7fe260b2c84p+6, 0x1.f360fe5fec85cp-1,
        0x0.0p+0, 0x0.0p+0, -0x1.c3eca9e466949p-3 },
    { 0x1.da57496b47bb7p+7, 0x1.26a3d135dff04p+8, -0x1.b2cf3eccc4695p+6, 0x1.d31301e87d689p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.a37481fb164d0p-2 },
    { 0x1.545627b917e95p+8, 0x1.9d2fe91455476p+7, -0x1.2a1d3aa369fcfp+6, 0x1.fc7690f1f0909p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.e09d5add72c5ep-4 },
    { 0x1.51932c24d962cp+8, -0x1.9a153e1c32752p+7, -0x1.d5067e846a5d7p+5, 0x1.f9582d3c78c71p-1,
        0x0.0p+0, 0x0.0p+0, -0x1.4924ee90fc512p-3 },
    { 0x1.512aaef7d6212p+8, -0x1.a48b07022539cp+7, -0x1.2c38a47ecfe9bp+6, 0x1.e66f4143432ddp-1,
        0x0.0p+0, 0x0.0p+0, -0x1.3f88897828c78p-2 },
    { 0x1.880ae12aac82dp+8, -0x1.0c3f95a76597ep+6, -0x1.0685f56a7ac82p+6, 0x1.ffc3fb440365dp-1,
        0x0.0p+0, 0x0.0p+0, 0x1.efc2f1a398ee2p-6 },
    { 0x1.eb439955495a2p+7, -0x1.2f9912e8875fdp+8, -0x1.51583d790752ep+6, 0x1.39910b48f2984p-1,
        0x0.0p+0, 0x0.0p+0, -0x1.94bf309d3ad39p-1 },
    { 0x1.6c24a2026c129p+8, -0x1.c35465c0cd5adp+6, -0x1.300bbbe878facp+6, 0x1.f6aa4407d4c5ep-1,
        0x0.0p+0, 0x0.0p+0, -0x1.854ae9616d422p-3 },
    { 0x1.8ddcac451de57p+8, 0x1.b63d53f3d25d2p+4, -0x1.0f902ea960b70p+6, 0x1.d236091b87743p-1,
        0x0.0p+0, 0x0.0p+0, 0x1.a7475e5de1f43p-2 },
    { 0x1.dfaf857933f00p+7, -0x1.2c594a8a4e086p+8, -0x1.64c332acfb763p+6, 0x1.cc60321f4e13ep-1,
        0x0.0p+0, 0x0.0p+0, -0x1.c0195141db7bbp-2 },
    { 0x1.37f76ee8ddbaep+8, -0x1.e1e496912c86dp+7, -0x1.471925785f8d3p+6, 0x1.a8cf6926fd1a9p-1,
        0x0.0p+0, 0x0.0p+0, -0x1.1dcc32a4c5e57p-1 },
};

static const scara_real scara_vector_inverse[24][4] = {
    { 0x1.5fc86cebbd67cp-3, -0x1.94ba51a00a2a5p-3, 0x1.eea28fe262752p-2, -0x1.9426ae7d566cfp+6 },
    { 0x1.3071822355cf8p-1, 0x1.1ff92f2bcafcap-4, 0x1.497e99630c23bp-1, -0x1.334f954eb13e0p+6 },
    { -0x1.c77ff151e5910p-4, 0x1.d9691a75cc9b2p-2, 0x1.8c9e44fa05144p-1, -0x1.55b01040bfe3bp+6 },
    { 0x1.80266772d6511p-1, 0x1.5f755369332fbp-1, -0x1.0808c8259e578p-1, -0x1.092ae03b3e9a7p+6 },
    { 0x1.4fa69be09a64ep-2, 0x1.6abead4f5a8dbp-1, 0x1.0f69ca9ef360dp-2, -0x1.a150385c67dfep+6 },
    { -0x1.ebb98c7e249f5p-3, -0x1.c492bc2fca1bep-2, 0x1.217f4128c9ca1p-5, -0x1.fda68e3ef2841p+5 },
    { 0x1.67b762d83ae28p-1, 0x1.0cbfb15b64706p-3, -0x1.7c61d8622fc9cp-2, -0x1.44f1b69121251p+5 },
    { -0x1.b1d92b7f8c19bp-7, 0x1.2008205feacebp-2, -0x1.3a109d0615f9bp-5, -0x1.8690ff10ecb75p+6 },
    { 0x1.3b7a1c25d2368p-2, 0x1.bb66b6177b8dap-2, -0x1.fa9c992859405p-2, -0x1.38d3ae2541d8fp+6 },
    { -0x1.c4cdfaca399e5p-3, -0x1.0dbcec84f6c5bp-1, -0x1.c8897e996545ep-2, -0x1.2ffec918e325dp+5 },
    { 0x1.3ac16df3f8480p-1, -0x1.81b4bb5e04f1ap-3, 0x1.885a4f00ebff2p-2, -0x1.be91fa7653437p+6 },
    { -0x1.95eaee1ffbc0ep-3, -0x1.f1ee24357be72p-3, 0x1.8305b7cfe8299p-1, -0x1.4292a5614df8bp+6 },
    { -0x1.01f31f460bf64p-11, 0x1.7589acbc8b2bcp-1, 0x1.4a4c404a73cc0p-1, -0x1.4d98bd230b9dcp+6 },
    { -0x1.3b9fdbd2fa0d7p-2, 0x1.f71151611b333p-2, -0x1.418f1d3ed4efap-1, -0x1.4e7fe260b2c84p+6 },
    { 0x1.345fe111276fbp-1, 0x1.5621fafc8ba96p-1, -0x1.b4ac29bf170c1p-2, -0x1.b2cf3eccc4695p+6 },
    { 0x1.d769a911025d1p-2, 0x1.8f0ae53661b5cp-3, -0x1.ae126202586ddp-2, -0x1.2a1d3aa369fcfp+6 },
    { -0x1.5f182235b5ceep-1, 0x1.47d2c7b8945a6p-2, 0x1.5e4c51115c78bp-5, -0x1.d5067e846a5d7p+5 },
    { -0x1.515f2452c680ep-1, 0x1.da87a072d7d6fp-3, -0x1.a8e25c810cfa2p-3, -0x1.2c38a47ecfe9bp+6 },
    { -0x1.0d8ba40d90011p-2, 0x1.b75fb2edfbd23p-3, 0x1.bf5a5332aebddp-4, -0x1.0685f56a7ac82p+6 },
    { -0x1.65adfb506eb7dp-1, -0x1.c253da72a519cp-2, -0x1.5eb228dc988c8p-1, -0x1.51583d790752ep+6 },
    { -0x1.f1d81f105f762p-6, -0x1.3d91cd1c7e55ap-1, 0x1.1294141e9af5cp-2, -0x1.300bbbe878facp+6 },
    { 0x1.14d2f5e4859c6p-11, 0x1.3f601797b71dbp-3, 0x1.64408d8ecc702p-1, -0x1.0f902ea960b70p+6 },
    { -0x1.4d04e618cdbc9p-1, -0x1.219cbee80864ap-1, 0x1.3dacabc515b90p-2, -0x1.64c332acfb763p+6 },
    { -0x1.03b3c819083cap-1, -0x1.60902de0102f9p-2, -0x1.54e26d47ffc46p-2, -0x1.471925785f8d3p+6 },
};

static const scara_real scara_vector_jacobians[4][24] = {
    { -0x1.0f7a2f0e22920p+5, 0x1.2182992a9181ap+2, 0x0.0p+0, 0x0.0p+0, 0x1.8ca162a6b31a9p+8,
        0x1.5de20f87df116p+7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0,
        0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0,
        0x0.0p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x0.0p+0 },
    { -0x1.d408f7b733c2dp+7, -0x1.afe5ff3e0abe0p+6, 0x0.0p+0, 0x0.0p+0, 0x1.4419c693aa6fcp+8,
        0x1.13700e65797a9p+7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0,
        0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0,
        0x0.0p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x0.0p+0 },
    { -0x1.19c1b25c6f52ep+5, -0x1.e183ddebf47e7p+5, 0x0.0p+0, 0x0.0p+0, 0x1.83ef0a08985a2p+8,
        0x1.48a5abb980099p+7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0,
        0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0,
        0x0.0p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x0.0p+0 },
    { -0x1.46d8c26866d10p+8, -0x1.5adc0a367daa2p+7, 0x0.0p+0, 0x0.0p+0, 0x1.77f37e359ce75p+7,
        0x1.763f92d2d28bbp+4, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0,
        0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0,
        0x0.0p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x1.0000000000000p+0, 0x0.0p+0 },
};

static const scara_real scara_vector_past[6][4] = {
    { -0x1.2cc9e4c57dc19p+1, -0x1.94ba51a005c46p-3, 0x1.eea28fe260b2dp-2, -0x1.9426ae7d566cfp+6 },
    { 0x1.2cc9e4c57dc19p+1, -0x1.94ba51a005c46p-3, 0x1.eea28fe260b2dp-2, -0x1.9426ae7d566cfp+6 },
    { 0x1.5fc86cebbba56p-3, -0x1.414c05d2f4e04p+1, 0x1.eea28fe260b2dp-2, -0x1.9426ae7d566cfp+6 },
    { 0x1.5fc86cebbba56p-3, 0x1.414c05d2f4e04p+1, 0x1.eea28fe260b2dp-2, -0x1.9426ae7d566cfp+6 },
    { 0x1.5fc86cebbba56p-3, -0x1.94ba51a005c46p-3, 0x1.eea28fe260b2dp-2, -0x1.2f00000000000p+7 },
    { 0x1.5fc86cebbba56p-3, -0x1.94ba51a005c46p-3, 0x1.eea28fe260b2dp-2, 0x1.8000000000000p+0 },
};

static const int scara_vector_blamed[6] = { 0, 0, 1, 1, 3, 3 };
static const scara_real scara_vector_singular[1][4] = {
    { 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
};


/* Error allowed, as a length. */
static const double scara_vector_bounds[24] = { 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09,
    1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09,
    1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09, 1.8e-09 };

#endif
