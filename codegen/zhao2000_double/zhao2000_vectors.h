/* Vectors for zhao2000_test.c, made by symkin's Python solvers; numbers are exact.
 * SPDX-License-Identifier: MIT */
#ifndef ZHAO2000_VECTORS_H
#define ZHAO2000_VECTORS_H

#include "zhao2000.h"

#define ZHAO2000_VECTORS 24
#define ZHAO2000_VECTOR_JACOBIANS 4
#define ZHAO2000_VECTOR_SINGULAR 0
#define ZHAO2000_VECTOR_FAR 0

static const zhao2000_real zhao2000_vector_guesses[24][7] = {
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.1f9c4d81b3b6ep+2, 0x1.c96b6c5479f05p-1, 0x1.c7d81a5c7e846p+6, 0x1.ff73c9f84a1f1p-1, 0x0.0p+0, 0x0.0p+0, 0x1.7ad0240e07363p-5 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.ab87527ad14b7p+1, 0x1.7b59bed1fc257p-3, 0x1.b36855f28f79ep+6, 0x1.ff401dac8350dp-1, 0x0.0p+0, 0x0.0p+0, 0x1.bb1bdf77fe138p-5 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.9b2cf7e1a1bbcp+0, -0x1.8709bd50d570ep-1, 0x1.65f71b47d8518p+6, 0x1.fffcd91d5dba6p-1, 0x0.0p+0, 0x0.0p+0, -0x1.c67d27d3b136ep-8 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.6b8c35bca5625p+3, 0x1.06ee9486edecfp+1, 0x1.7f6eb3c8a5e8ep+6, 0x1.ffed4d6160b8ap-1, 0x0.0p+0, 0x0.0p+0, 0x1.14bb52c44e52dp-6 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.3bcc6f270b4efp+2, 0x1.a688641dbbf19p+2, 0x1.717801f3390c0p+6, 0x1.fff9f380d5c88p-1, 0x0.0p+0, 0x0.0p+0, -0x1.3acdcd54e5d60p-7 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.a2ba8a8bfcd16p+1, 0x1.d9832270d98c1p-1, 0x1.61512249df7abp+6, 0x1.fff4978d31c5ep-1, 0x0.0p+0, 0x0.0p+0, -0x1.b051ea6268bc7p-7 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.c8dbc66654937p+1, 0x1.86c4007125427p-1, 0x1.9897487aff35ep+6, 0x1.ff7d17f9a4684p-1, 0x0.0p+0, 0x0.0p+0, 0x1.6e08cc785bcbfp-5 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.0b7cb5d458747p+2, 0x1.a07ae551438dap+2, 0x1.bbf492e77df20p+6, 0x1.fffd1614531c9p-1, 0x0.0p+0, 0x0.0p+0, -0x1.b4fb79b025466p-8 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.115bd674d42dep+0, -0x1.5ba22a4b2b6d3p+2, 0x1.57d026d17b076p+6, 0x1.ffa06b80fa1fdp-1, 0x0.0p+0, 0x0.0p+0, 0x1.38ca885524d00p-5 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.46d097abaf7b1p-1, 0x1.1ef17b9ae57afp+2, 0x1.81a8e1d620120p+6, 0x1.fff98c1aa0474p-1, 0x0.0p+0, 0x0.0p+0, -0x1.4524e952e32a0p-7 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.b0489c69483c3p+1, -0x1.1e08828fcfb1dp+2, 0x1.8d7311b50ca65p+6, 0x1.fffff4677e6c4p-1, 0x0.0p+0, 0x0.0p+0, -0x1.b3df392702fc4p-11 },
    { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { 0x1.02abbccfa6316p+2, 0x1.b8efce97dbb1fp+2, 0x1.b9ab99a7d8e2ep+6, 0x1.fffdcd2b32049p-1, 0x0.0p+0, 0x0.0p+0, -0x1.7b955d0939e30p-8 },
};

static const zhao2000_real zhao2000_vector_joints[24][4] = {
    { 0x1.813bd387fab83p+0, 0x1.d3a70c1c32281p+1, 0x1.6959bdcdb099fp+2, 0x1.929ac075a6755p+6 },
    { 0x1.8b25e35bad525p+0, 0x1.c4b209a636228p+1, 0x1.68e9e7e75f97ap+2, 0x1.c8053b3dc3affp+6 },
    { 0x1.a1073d7e38979p+0, 0x1.d32c9486cf54ep+1, 0x1.734e1050346d5p+2, 0x1.758f71f86ae05p+6 },
    { 0x1.82e864751d65dp+0, 0x1.c4c2c6217c13fp+1, 0x1.6805ef1983006p+2, 0x1.b36bce8533b10p+6 },
    { 0x1.aa2f8b7b1bacap+0, 0x1.c222aa22420c9p+1, 0x1.6d59c128aeed5p+2, 0x1.60a9aeba930e6p+6 },
    { 0x1.8fa9853c3d4a8p+0, 0x1.d9a9ed7802328p+1, 0x1.7197fa13b2060p+2, 0x1.65d80c9befb53p+6 },
    { 0x1.a1abe63f8d611p+0, 0x1.d97b873329bb6p+1, 0x1.6ffcf49efdff0p+2, 0x1.78a10822e4309p+6 },
    { 0x1.b241ab385055fp+0, 0x1.c5260952534c5p+1, 0x1.69cb01ddaae30p+2, 0x1.8202e9bf4bdadp+6 },
    { 0x1.7fa1dbfa90010p+0, 0x1.d99b60ed44d4cp+1, 0x1.7459570b03e1ap+2, 0x1.a77d17ee334eep+6 },
    { 0x1.a72886a41c56ep+0, 0x1.c8ac7009418a9p+1, 0x1.7557bf90ff38cp+2, 0x1.72beae2618988p+6 },
    { 0x1.94e38bc848861p+0, 0x1.ca6feda1f39dap+1, 0x1.769b7741044eap+2, 0x1.62d4569969c8fp+6 },
    { 0x1.8ccfed85d2bfcp+0, 0x1.da477fc4a070dp+1, 0x1.746770738ab3bp+2, 0x1.6162f23d9f9dcp+6 },
    { 0x1.b74de27e37c0dp+0, 0x1.cd13d78c07a31p+1, 0x1.6f958df2f77b6p+2, 0x1.796902f8d8c45p+6 },
    { 0x1.6ec9c11be769ap+0, 0x1.cb55a66370ab1p+1, 0x1.6d4abe566c95bp+2, 0x1.98a8e20bf9328p+6 },
    { 0x1.711102f9d84b2p+0, 0x1.e5afdc39ec4d4p+1, 0x1.6ad4b8758204bp+2, 0x1.936337ddbcdf2p+6 },
    { 0x1.87156b3e6542ep+0, 0x1.cfbeae64c6ec6p+1, 0x1.7881ea725452dp+2, 0x1.bcd705a052f14p+6 },
    { 0x1.9a9a51c2933a7p+0, 0x1.ccafdca54c17bp+1, 0x1.69fc538f4e5e9p+2, 0x1.8c0206d5dd16cp+6 },
    { 0x1.78c1eebf8ea33p+0, 0x1.d507f428f65bcp+1, 0x1.685e9644d5948p+2, 0x1.585559cea86f2p+6 },
    { 0x1.948b35c5dd71dp+0, 0x1.d103af1fd7cf0p+1, 0x1.7a24e14d11a32p+2, 0x1.818ba2cb71830p+6 },
    { 0x1.94a0d3bcd3dddp+0, 0x1.d0e84e71414e2p+1, 0x1.75de3cee22298p+2, 0x1.81e494d50ebabp+6 },
    { 0x1.7f77d81b076fdp+0, 0x1.d37ed88be1e36p+1, 0x1.76702ebdddbe2p+2, 0x1.92899e0e73605p+6 },
    { 0x1.9fda914dc384cp+0, 0x1.d91142f1b14b1p+1, 0x1.6b882ac885b7cp+2, 0x1.8de37c3bbac13p+6 },
    { 0x1.89997cb07d8e3p+0, 0x1.e08c0be5ab835p+1, 0x1.6c2db88c28396p+2, 0x1.b412ba16e7a31p+6 },
    { 0x1.87318b2f9c524p+0, 0x1.ceabb7113dd85p+1, 0x1.78aba7db000ddp+2, 0x1.baa1e95ed3cafp+6 },
};

static const zhao2000_real zhao2000_vector_poses[24][7] = {
    { -0x1.eab59b1a06c34p-4, -0x1.0df5b4fcbb40dp+2, 0x1.9240216261854p+6, 0x1.ffbcfc022c50fp-1, 0x0.0p+0, 0x0.0p+0, 0x1.05eda39db42f9p-5 },
    { -0x1.1f9c1f042204bp+2, 0x1.c9e5999fbf46bp-1, 0x1.c7a6e779eea5ep+6, 0x1.ff732a9b5f32bp-1, 0x0.0p+0, 0x0.0p+0, 0x1.7ba710ae79126p-5 },
    { -0x1.1ae50a83082a1p+1, 0x1.1ddc41da6af01p+1, 0x1.75594e91095c9p+6, 0x1.fff2e2ca57ec6p-1, 0x0.0p+0, 0x0.0p+0, -0x1.cf8515e1b0a3ap-7 },
    { -0x1.ab8ae55a2d0a3p+1, 0x1.7cbc3d8876b19p-3, 0x1.b33727e99615bp+6, 0x1.ff3f618960ab9p-1, 0x0.0p+0, 0x0.0p+0, 0x1.bbf4bbf094adcp-5 },
    { -0x1.2cd03e7ea5536p+3, 0x1.3038bd12148bap+2, 0x1.5e22f9958b4abp+6, 0x1.ffec0ca7d8d18p-1, 0x0.0p+0, 0x0.0p+0, 0x1.1dda140575208p-6 },
    { 0x1.9b22603414a70p+0, -0x1.87334a4acb012p-1, 0x1.65c5f1ef0f24bp+6, 0x1.fffcf03ad5aa1p-1, 0x0.0p+0, 0x0.0p+0, -0x1.bfee84ec7649ep-8 },
    { -0x1.12930e312579dp+1, -0x1.cbd99e62f4447p+0, 0x1.78767480555bfp+6, 0x1.fff2e18be62c4p-1, 0x0.0p+0, 0x0.0p+0, -0x1.cf9b10d1e082dp-7 },
    { -0x1.6b8a1ae48cfbep+3, 0x1.0739f29350975p+1, 0x1.7f3d2cf21de19p+6, 0x1.ffed145766f16p-1, 0x0.0p+0, 0x0.0p+0, 0x1.166023afc9f29p-6 },
    { 0x1.64bd846eb8652p+2, 0x1.31b654b61bcd9p+0, 0x1.a6dfd399d1951p+6, 0x1.ffff3b5ae5351p-1, 0x0.0p+0, 0x0.0p+0, -0x1.c0bc5e0ed865bp-9 },
    { -0x1.3bb62e463b2d1p+2, 0x1.a697bafbbd45ep+2, 0x1.7146aa7d65b31p+6, 0x1.fffa139b3caa4p-1, 0x0.0p+0, 0x0.0p+0, -0x1.37860f533c7bfp-7 },
    { -0x1.6008ab3760456p-2, 0x1.b0ca26aa544b0p+2, 0x1.61cb548ac3535p+6, 0x1.ffff38ad1ff1ep-1, 0x0.0p+0, 0x0.0p+0, -0x1.c3c82b29467fbp-9 },
    { 0x1.a2bf78dfb06c5p+1, 0x1.d92c1a1f9cf09p-1, 0x1.611ff26aae2e3p+6, 0x1.fff4c3be96a11p-1, 0x0.0p+0, 0x0.0p+0, -0x1.ad096322dafb6p-7 },
    { -0x1.1c95bd8af3353p+3, 0x1.1a0f46960fc20p+1, 0x1.77a066f1f75fcp+6, 0x1.fff7a2efd0737p-1, 0x0.0p+0, 0x0.0p+0, -0x1.722ac669db904p-7 },
    { 0x1.c8e4fd5cd9ed1p+1, 0x1.866a09799f7ffp-1, 0x1.9866184d4ce69p+6, 0x1.ff7c7e3e125f0p-1, 0x0.0p+0, 0x0.0p+0, 0x1.6edf601643639p-5 },
    { 0x1.72f30419d4b83p+2, -0x1.29be69f54f128p+3, 0x1.90ff4fa29b192p+6, 0x1.fff2661889305p-1, 0x0.0p+0, 0x0.0p+0, 0x1.d80c8e6c96d57p-7 },
    { 0x1.0b91ab83ed591p+2, 0x1.a06ca241f1ad8p+2, 0x1.bbc34e36f68a8p+6, 0x1.fffd2c4bf4e1ep-1, 0x0.0p+0, 0x0.0p+0, -0x1.ae6ce89b1e785p-8 },
    { -0x1.5a5e9c8b9a053p+2, -0x1.10359f11c9434p+0, 0x1.8b64949f3909cp+6, 0x1.ffde1f81fbc54p-1, 0x0.0p+0, 0x0.0p+0, 0x1.747b158114e97p-6 },
    { 0x1.1116ca512f631p+0, -0x1.5ba8660ba7c7fp+2, 0x1.579ee2f28d829p+6, 0x1.ff9fe8f348995p-1, 0x0.0p+0, 0x0.0p+0, 0x1.399fcac478f59p-5 },
    { 0x1.1bf663b4f34bcp+1, 0x1.c3b4019a5b76dp+2, 0x1.806874ee6cef4p+6, 0x1.ffe277430f7f0p-1, 0x0.0p+0, 0x0.0p+0, -0x1.5bca5947e5d05p-6 },
    { 0x1.474575f9280aep-1, 0x1.1eeecf34af54ep+2, 0x1.8177ad7c3ca0fp+6, 0x1.fff9ad45029d1p-1, 0x0.0p+0, 0x0.0p+0, -0x1.41dd1c2a5e63bp-7 },
    { 0x1.5feb390f45614p+2, 0x1.1038e61256097p+2, 0x1.9193718437eecp+6, 0x1.fffff1246080ap-1, 0x0.0p+0, 0x0.0p+0, -0x1.ed635b14319d9p-11 },
    { -0x1.b065d4521ea83p+1, -0x1.1dfd657507908p+2, 0x1.8d41d6db3e60bp+6, 0x1.fffff706ae675p-1, 0x0.0p+0, 0x0.0p+0, -0x1.7f715b284202fp-11 },
    { 0x1.ca7f6ae4e85c0p+0, -0x1.a8a8aa6a9d0dep+2, 0x1.b334ab671a981p+6, 0x1.ffffb38b05ecap-1, 0x0.0p+0, 0x0.0p+0, 0x1.17ce8747e8fdep-9 },
    { 0x1.02c20202f4022p+2, 0x1.b8e20ad2e27dap+2, 0x1.b97a528b5dd9bp+6, 0x1.fffde0717517bp-1, 0x0.0p+0, 0x0.0p+0, -0x1.7507016fa5ef2p-8 },
};

static const zhao2000_real zhao2000_vector_inverse[24][4] = {
    { 0x1.813bd387fab83p+0, 0x1.d3a70c1c32281p+1, 0x1.6959bdcdb099fp+2, 0x1.929ac075a6755p+6 },
    { 0x1.8b25e35bad525p+0, 0x1.c4b209a636228p+1, 0x1.68e9e7e75f97ap+2, 0x1.c8053b3dc3affp+6 },
    { 0x1.a1073d7e38979p+0, 0x1.d32c9486cf54ep+1, 0x1.734e1050346d5p+2, 0x1.758f71f86ae05p+6 },
    { 0x1.82e864751d65dp+0, 0x1.c4c2c6217c13fp+1, 0x1.6805ef1983006p+2, 0x1.b36bce8533b10p+6 },
    { 0x1.aa2f8b7b1bacap+0, 0x1.c222aa22420c9p+1, 0x1.6d59c128aeed5p+2, 0x1.60a9aeba930e6p+6 },
    { 0x1.8fa9853c3d4a8p+0, 0x1.d9a9ed7802328p+1, 0x1.7197fa13b2060p+2, 0x1.65d80c9befb53p+6 },
    { 0x1.a1abe63f8d611p+0, 0x1.d97b873329bb6p+1, 0x1.6ffcf49efdff0p+2, 0x1.78a10822e4309p+6 },
    { 0x1.b241ab385055fp+0, 0x1.c5260952534c5p+1, 0x1.69cb01ddaae30p+2, 0x1.8202e9bf4bdadp+6 },
    { 0x1.7fa1dbfa90010p+0, 0x1.d99b60ed44d4cp+1, 0x1.7459570b03e1ap+2, 0x1.a77d17ee334eep+6 },
    { 0x1.a72886a41c56ep+0, 0x1.c8ac7009418a9p+1, 0x1.7557bf90ff38cp+2, 0x1.72beae2618988p+6 },
    { 0x1.94e38bc848861p+0, 0x1.ca6feda1f39dap+1, 0x1.769b7741044eap+2, 0x1.62d4569969c8fp+6 },
    { 0x1.8ccfed85d2bfcp+0, 0x1.da477fc4a070dp+1, 0x1.746770738ab3bp+2, 0x1.6162f23d9f9dcp+6 },
    { 0x1.b74de27e37c0dp+0, 0x1.cd13d78c07a31p+1, 0x1.6f958df2f77b6p+2, 0x1.796902f8d8c45p+6 },
    { 0x1.6ec9c11be769ap+0, 0x1.cb55a66370ab1p+1, 0x1.6d4abe566c95bp+2, 0x1.98a8e20bf9328p+6 },
    { 0x1.711102f9d84b2p+0, 0x1.e5afdc39ec4d4p+1, 0x1.6ad4b8758204bp+2, 0x1.936337ddbcdf2p+6 },
    { 0x1.87156b3e6542ep+0, 0x1.cfbeae64c6ec6p+1, 0x1.7881ea725452dp+2, 0x1.bcd705a052f14p+6 },
    { 0x1.9a9a51c2933a7p+0, 0x1.ccafdca54c17bp+1, 0x1.69fc538f4e5e9p+2, 0x1.8c0206d5dd16cp+6 },
    { 0x1.78c1eebf8ea33p+0, 0x1.d507f428f65bcp+1, 0x1.685e9644d5948p+2, 0x1.585559cea86f2p+6 },
    { 0x1.948b35c5dd71dp+0, 0x1.d103af1fd7cf0p+1, 0x1.7a24e14d11a32p+2, 0x1.818ba2cb71830p+6 },
    { 0x1.94a0d3bcd3dddp+0, 0x1.d0e84e71414e2p+1, 0x1.75de3cee22298p+2, 0x1.81e494d50ebabp+6 },
    { 0x1.7f77d81b076fdp+0, 0x1.d37ed88be1e36p+1, 0x1.76702ebdddbe2p+2, 0x1.92899e0e73605p+6 },
    { 0x1.9fda914dc384cp+0, 0x1.d91142f1b14b1p+1, 0x1.6b882ac885b7cp+2, 0x1.8de37c3bbac13p+6 },
    { 0x1.89997cb07d8e3p+0, 0x1.e08c0be5ab835p+1, 0x1.6c2db88c28396p+2, 0x1.b412ba16e7a31p+6 },
    { 0x1.87318b2f9c524p+0, 0x1.ceabb7113dd85p+1, 0x1.78aba7db000ddp+2, 0x1.baa1e95ed3cafp+6 },
};

static const zhao2000_real zhao2000_vector_jacobians[4][24] = {
    { -0x1.f4597433b03b0p-7, 0x1.087a23bcdb839p-10, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.0d1fe904f7f2ap+0, 0x1.c01fd46975d0cp-8, -0x1.8ebfe0b20540fp-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.edb944fd01955p-1, 0x1.0f2212ec9a314p-7, 0x1.6e62ed49bfc8ap-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.e5ab36158efe2p-1, -0x1.3805b8a3357eep-10, -0x1.575029ca3a06ap-5, 0x1.ff8cc1484e115p-1, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.d09eef310a3ffp-7, 0x1.953dd2391678cp-12, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.f38977040fd18p-1, 0x1.56931bbc79368p-8, -0x1.9abe368dd9e88p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.d603caf8a7c02p-1, 0x1.2b57a86eafc74p-7, 0x1.8ec8cd30415dcp-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.07cabbf0b1837p+0, -0x1.42ea77716a6a4p-5, 0x1.010dab282628ap-7, 0x1.ff9617ef5ff4bp-1, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.c8779c7c74861p-7, -0x1.a9b13d19fee93p-11, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.ed20b60d55999p-1, 0x1.c6d409cbe9749p-8, -0x1.9847c3c6bb513p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.f9df471961537p-1, 0x1.c98d53f05502bp-8, 0x1.b5c8c8caf951dp-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.0ab36bd16d172p+0, -0x1.83bbee6e8d456p-6, 0x1.87cc827a184a0p-6, 0x1.ffb5cc5dc4b4ep-1, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
    { -0x1.d34c2f7ae4443p-7, 0x1.bced2306ffc96p-11, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.f3a2947ea27e6p-1, 0x1.598d1b234a719p-8, -0x1.9db7880272950p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.d7d82b3cd422bp-1, 0x1.29a579e664bd3p-7, 0x1.813dd85ec3884p-7, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0, -0x1.ff91b6379453dp-1, -0x1.f6bc5e596b700p-6, 0x1.bfb2486c49622p-10, 0x1.ffc216ddb4730p-1, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 },
};

static const zhao2000_real zhao2000_vector_home[7] = { 0x0.0p+0, 0x0.0p+0, 0x1.9000000000000p+6, 0x1.0000000000000p+0, 0x0.0p+0, 0x0.0p+0, 0x0.0p+0 };
static const zhao2000_real zhao2000_vector_far[7] = { -0x1.2cd03e7ea5536p+3, 0x1.3038bd12148bap+2, 0x1.5e22f9958b4abp+6, 0x1.ffec0ca7d8d18p-1, 0x0.0p+0, 0x0.0p+0, 0x1.1dda140575208p-6 };

/* Error allowed, as a length. */
static const double zhao2000_vector_bounds[24] = { 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09, 1.1e-09 };

#endif
