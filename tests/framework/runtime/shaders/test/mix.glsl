// SPDX-License-Identifier: Apache-2.0
// A hash of all that a pass reads, for mix.comp, mix.vert and mix.frag. Inputs r0 to r2 are of the
// kinds that the variant says: R0_WORDS a storage buffer, R0_UNIFORM a uniform buffer, R0_SAMPLED a
// sampled image, R0_STORAGE a storage image. hash_passes.cpp has the same for the CPU.
#extension GL_EXT_scalar_block_layout : require

layout(push_constant, scalar) uniform Push {
    uint seed;
    uint flags;            // 1: values are group counts; 2: some fragments are discarded
    uint uniform_words[3]; // of the inputs that are uniform buffers
    uint width;            // of the attachments
    uint height;
} push;

uint hash(uint x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}
// Images hold multiples of 2^-24 in [0, 1), which depth formats hold exactly too.
float texel_of(uint h) { return float(h >> 8) * (1.0 / 16777216.0); }

ivec3 place_of(ivec3 size, uint index) {
    const uvec3 s = uvec3(size);
    return ivec3(index % s.x, index / s.x % s.y, index / (s.x * s.y));
}
// `h` with the texels `index`, `index + count`, ... of all mips; mip by mip, since lavapipe fetches
// for a quad of invocations from one mip.
uint mix_texels(sampler2DArray image, uint h, uint index, uint count) {
    uint all = 0;
    for (int mip = 0; mip < textureQueryLevels(image); ++mip) {
        const ivec3 size = textureSize(image, mip);
        all += uint(size.x * size.y * size.z);
    }
    uint begin = 0;
    uint i = index % all;
    for (int mip = 0; mip < textureQueryLevels(image); ++mip) {
        const ivec3 size = textureSize(image, mip);
        const uint end = begin + uint(size.x * size.y * size.z);
        for (; i < end; i += count)
            h = hash(h + floatBitsToUint(texelFetch(image, place_of(size, i - begin), mip).r));
        begin = end;
    }
    return h;
}
#define STORAGE_COUNT(image) uint(imageSize(image).x * imageSize(image).y * imageSize(image).z)
#define STORAGE_VALUE(image, index) \
    floatBitsToUint(imageLoad(image, place_of(imageSize(image), index)).r)

#if defined(R0_WORDS)
layout(binding = 0, scalar) readonly buffer R0 { uint values[]; } r0;
#define COUNT0 uint(r0.values.length())
#define VALUE0(index) r0.values[index]
#elif defined(R0_UNIFORM)
layout(binding = 0, scalar) uniform R0 { uint values[256]; } r0;
#define COUNT0 push.uniform_words[0]
#define VALUE0(index) r0.values[index]
#elif defined(R0_SAMPLED)
layout(binding = 0) uniform sampler2DArray r0;
#define MIX0(h, index, count) mix_texels(r0, h, index, count)
#elif defined(R0_STORAGE)
layout(binding = 0, r32f) uniform readonly image2DArray r0;
#define COUNT0 STORAGE_COUNT(r0)
#define VALUE0(index) STORAGE_VALUE(r0, index)
#endif

#if defined(R1_WORDS)
layout(binding = 1, scalar) readonly buffer R1 { uint values[]; } r1;
#define COUNT1 uint(r1.values.length())
#define VALUE1(index) r1.values[index]
#elif defined(R1_UNIFORM)
layout(binding = 1, scalar) uniform R1 { uint values[256]; } r1;
#define COUNT1 push.uniform_words[1]
#define VALUE1(index) r1.values[index]
#elif defined(R1_SAMPLED)
layout(binding = 1) uniform sampler2DArray r1;
#define MIX1(h, index, count) mix_texels(r1, h, index, count)
#elif defined(R1_STORAGE)
layout(binding = 1, r32f) uniform readonly image2DArray r1;
#define COUNT1 STORAGE_COUNT(r1)
#define VALUE1(index) STORAGE_VALUE(r1, index)
#endif

#if defined(R2_WORDS)
layout(binding = 2, scalar) readonly buffer R2 { uint values[]; } r2;
#define COUNT2 uint(r2.values.length())
#define VALUE2(index) r2.values[index]
#elif defined(R2_UNIFORM)
layout(binding = 2, scalar) uniform R2 { uint values[256]; } r2;
#define COUNT2 push.uniform_words[2]
#define VALUE2(index) r2.values[index]
#elif defined(R2_SAMPLED)
layout(binding = 2) uniform sampler2DArray r2;
#define MIX2(h, index, count) mix_texels(r2, h, index, count)
#elif defined(R2_STORAGE)
layout(binding = 2, r32f) uniform readonly image2DArray r2;
#define COUNT2 STORAGE_COUNT(r2)
#define VALUE2(index) STORAGE_VALUE(r2, index)
#endif

// For element `index` of `count`: together these read every element of every input.
uint mix_inputs(uint seed, uint index, uint count) {
    uint h = hash(seed + index);
#if defined(MIX0)
    h = MIX0(h, index, count);
#elif defined(COUNT0)
    const uint count0 = COUNT0;
    for (uint i = index % count0; i < count0; i += count) h = hash(h + VALUE0(i));
#endif
#if defined(MIX1)
    h = MIX1(h, index, count);
#elif defined(COUNT1)
    const uint count1 = COUNT1;
    for (uint i = index % count1; i < count1; i += count) h = hash(h + VALUE1(i));
#endif
#if defined(MIX2)
    h = MIX2(h, index, count);
#elif defined(COUNT2)
    const uint count2 = COUNT2;
    for (uint i = index % count2; i < count2; i += count) h = hash(h + VALUE2(i));
#endif
    return h;
}

// The storage that is written: W0, W1 or W say its name, TO_WORDS or TO_TEXELS its kind, OLD that
// the pass also reads what was there.
#if defined(W0)
#define TARGET w0
#elif defined(W1)
#define TARGET w1
#elif defined(W)
#define TARGET w
#endif
#if defined(OLD)
#define DIRECTION
#else
#define DIRECTION writeonly
#endif
#if defined(TO_WORDS)
layout(binding = 3, scalar) DIRECTION buffer Target { uint values[]; } TARGET;
#define TARGET_COUNT uint(TARGET.values.length())
void write_target(uint index, uint h) {
#if defined(OLD)
    h = hash(h + TARGET.values[index]);
#endif
    TARGET.values[index] = (push.flags & 1) != 0 ? 1 + h % 3 : h;
}
#elif defined(TO_TEXELS)
layout(binding = 3, r32f) DIRECTION uniform image2DArray TARGET;
#define TARGET_COUNT STORAGE_COUNT(TARGET)
void write_target(uint index, uint h) {
    const ivec3 place = place_of(imageSize(TARGET), index);
#if defined(OLD)
    h = hash(h + floatBitsToUint(imageLoad(TARGET, place).r));
#endif
    imageStore(TARGET, place, vec4(texel_of(h)));
}
#endif
