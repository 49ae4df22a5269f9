// SPDX-License-Identifier: Apache-2.0
// Phase function of Henyey and Greenstein 1941: how light turns when it is scattered.
//   p(c) = (1 - g^2) / (4 pi (1 + g^2 - 2 g c)^(3/2)),   c = cosine between the directions of travel
// It integrates to 1 over the sphere; its mean cosine is g, in (-1, 1): forward where g > 0. Both
// functions are written in 1 - c, which keeps its precision in the peak of |g| near 1.
#ifndef OCKHAM_PHASE_GLSL
#define OCKHAM_PHASE_GLSL

/// Per steradian.
float phase(float g, float cosine) {
    float a = abs(g);
    float turned = 1.0 - (g < 0.0 ? -cosine : cosine);
    float square = (1.0 - a) * (1.0 - a) + 2.0 * a * turned;
    return (1.0 - a * a) / (12.5663706 * square * sqrt(square));
}

/// Two unit vectors that make an orthonormal basis with the unit vector n (Duff et al. 2017).
void basis_around(vec3 n, out vec3 tangent, out vec3 bitangent) {
    float s = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    tangent = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    bitangent = vec3(b, s + n.y * n.y * a, -n.y);
}

/// A direction with density phase(g, dot(forward, direction)); `forward`: unit, the way that light
/// (or a path) travels; `xi` in (0, 1).
vec3 sample_phase(float g, vec3 forward, vec2 xi) {
    float a = abs(g);
    float denominator = 1.0 - a + 2.0 * a * xi.x;
    float s = (1.0 - a * a) / denominator; // sqrt(1 + a^2 - 2 a c)
    float turned = min((1.0 - a) * (1.0 - xi.x) * (s + 1.0 - a) / denominator, 2.0); // 1 - c
    float cosine = g < 0.0 ? turned - 1.0 : 1.0 - turned;
    float sine = sqrt(turned * (2.0 - turned));
    float azimuth = 6.28318531 * xi.y;
    vec3 tangent, bitangent;
    basis_around(forward, tangent, bitangent);
    return normalize(
        sine * (cos(azimuth) * tangent + sin(azimuth) * bitangent) + cosine * forward);
}

#endif
