// SPDX-License-Identifier: Apache-2.0
// The visibility layout behind surface_sample.glsl: 4 bytes a sample name the triangle; where the
// sample's ray meets its plane gives depth and attributes, with derivatives exact under projection:
//   u = D . (e2 x c) / D . n,   v = D . (c x e1) / D . n,   n = e1 x e2,   depth = c . n / D . n
// D: the ray; c: the first corner, seen from the ray's origin; e1, e2: the edges from there
// (Moeller and Trumbore 1997, in the order that leaves D alone linear in the sample's place).
// Burns and Hunt, The Visibility Buffer, JCGT 2013.

#include "include/footprint.glsl"
#include "surface/vertex.glsl"

layout(constant_id = SPEC_NORMAL_MAPS) const bool kNormalMaps = true;
layout(constant_id = SPEC_SHADING_DATA_TEXTURES) const bool kShadingDataTextures = true;
layout(constant_id = SPEC_SECOND_COORDINATES) const bool kSecondCoordinates = true;

layout(binding = 1, r32ui) uniform readonly uimage2D gbuffer;
// Whole rows, since drivers load scalars one by one: three corners; the members of a TriangleBlock.
layout(scalar, binding = 22) readonly buffer Indices { uvec3 items[]; } indices;
layout(scalar, binding = 23) readonly buffer TriangleBlocks { uvec4 items[]; } triangle_blocks;
layout(scalar, binding = 24) readonly buffer Materials { MaterialData items[]; } materials;
#ifdef DATA_TEXTURES
layout(binding = 26) uniform sampler2DArray data_textures;
#endif

/// Samples with the same id lie on one plane and have one material. NO_TRIANGLE: background.
uint fetch_triangle(ivec2 position) { return imageLoad(gbuffer, position).x; }

struct Triangle {
    InstanceData instance;
    uint material;
    uvec3 vertices; // where they start in the buffer
    vec3 corner;    // the first, from the camera, world
    vec3 edge1, edge2;
    mat3 normals;   // of the vertices, of the instance
    mat3x2 uv0;
};

/// Of NO_TRIANGLE: some triangle.
Triangle fetch_corners(uint id) {
    uvec4 row = triangle_blocks.items[id >> TRIANGLE_BLOCK_BITS];
    TriangleBlock block = TriangleBlock(row.x, int(row.y), row.z, row.w);
    uvec3 corners = indices.items[block.first_index / 3u + (id & (TRIANGLES_PER_BLOCK - 1u))];
    Triangle t;
    t.instance = instances.items[block.instance];
    t.material = block.material;
    t.vertices = uvec3(ivec3(corners) + block.vertex_offset) * kVertexStride;
    Vertex a = fetch_vertex(t.vertices.x), b = fetch_vertex(t.vertices.y), c = fetch_vertex(t.vertices.z);
    t.corner = to_world(t.instance, a.position) - frame.data.position;
    t.edge1 = to_world_tangent(t.instance, b.position - a.position);
    t.edge2 = to_world_tangent(t.instance, c.position - a.position);
    t.normals = mat3(a.normal, b.normal, c.normal);
    t.uv0 = mat3x2(a.uv0, b.uv0, c.uv0);
    return t;
}

/// Where a sample's ray meets a triangle.
struct Hit {
    vec2 weights;            // of the second and third vertex
    vec2 weights_x, weights_y; // their change per sample to the right and down
    float depth;             // stored
    vec2 slope;
    bool front;
};

Hit hit_triangle(Triangle t, ivec2 position) {
    bool parallel = frame.data.orthographic != 0u;
    vec3 forward = frame.data.forward, x = sample_right(), y = sample_down();
    vec3 across = sample_across(position);
    vec3 ray = parallel ? forward : forward + across;
    vec3 corner = parallel ? t.corner - across : t.corner;
    vec3 a = cross(t.edge2, corner), b = cross(corner, t.edge1), n = cross(t.edge1, t.edge2);
    float facing = dot(ray, n);
    float inverse = 1.0 / (facing == 0.0 ? 1e-30 : facing);
    float height = dot(corner, n);

    Hit hit;
    hit.front = facing * handedness(t.instance) < 0.0;
    vec2 w = vec2(dot(ray, a), dot(ray, b)) * inverse;
    if (parallel) {
        vec3 normal_x = cross(ray, t.edge1), normal_y = cross(ray, t.edge2);
        hit.weights_x = vec2(-dot(normal_y, x), dot(normal_x, x)) * inverse;
        hit.weights_y = vec2(-dot(normal_y, y), dot(normal_x, y)) * inverse;
        hit.depth = 1.0 - height * inverse / frame.data.far_distance;
        hit.slope = vec2(dot(x, n), dot(y, n)) * inverse / frame.data.far_distance;
    } else {
        hit.weights_x = (vec2(dot(x, a), dot(x, b)) - w * dot(x, n)) * inverse;
        hit.weights_y = (vec2(dot(y, a), dot(y, b)) - w * dot(y, n)) * inverse;
        float scale = frame.data.near_distance / height;
        hit.depth = facing * scale;
        hit.slope = vec2(dot(x, n), dot(y, n)) * scale;
    }
    // Rasterisers move corners to a grid, so rays may pass the triangle by; those along its plane
    // may meet it anywhere.
    w = max(w, 0.0);
    hit.weights = w / max(w.x + w.y, 1.0);
    float d0 = dot(t.corner, forward), d1 = d0 + dot(t.edge1, forward), d2 = d0 + dot(t.edge2, forward);
    float farthest = max(d0, max(d1, d2)), nearest = max(min(d0, min(d1, d2)), frame.data.near_distance);
    vec2 range = parallel ? 1.0 - vec2(farthest, nearest) / frame.data.far_distance
                          : frame.data.near_distance / vec2(farthest, nearest);
    hit.depth = clamp(hit.depth, range.x, range.y);
    return hit;
}

/// Of the three vertices.
vec3 weights_of(Hit hit) { return vec3(1.0 - hit.weights.x - hit.weights.y, hit.weights); }

/// Change of the coordinates per sample, right in column 0 and down in column 1.
mat2 derivatives_of(Hit hit, mat3x2 uv) {
    return mat2(uv[1] - uv[0], uv[2] - uv[0]) * mat2(hit.weights_x, hit.weights_y);
}

TextureCoordinates coordinates_at(Triangle t, Hit hit, UvMap map) {
    mat3x2 uv1 = mat3x2(fetch_uv1(t.vertices.x), fetch_uv1(t.vertices.y), fetch_uv1(t.vertices.z));
    mat2 d0 = derivatives_of(hit, t.uv0), d1 = derivatives_of(hit, uv1);
    vec3 weights = weights_of(hit);
    TextureCoordinates c =
        map_coordinates(map, t.uv0 * weights, uv1 * weights, UvDerivatives(d0[0], d1[0], d0[1], d1[1]));
    c.uv = fract(c.uv);
    return c;
}

vec3 normal_at(Triangle t, Hit hit) {
    vec3 weights = weights_of(hit);
    vec3 normal = normalize(mat3(normalize(to_world_normal(t.instance, t.normals[0])),
                                normalize(to_world_normal(t.instance, t.normals[1])),
                                normalize(to_world_normal(t.instance, t.normals[2]))) * weights);
#ifdef DATA_TEXTURES
    MaterialData material = materials.items[t.material];
    if (kNormalMaps && material.normal_texture.layer >= 0) {
        TextureCoordinates bump = coordinates_at(t, hit, material.uv[2]);
        vec3 texel = sample_footprint(data_textures, material.normal_texture.layer,
            material.normal_texture.size, bump.uv, bump.gradient_x, bump.gradient_y, 2.0).xyz;
        vec4 tangent = mat3x4(fetch_tangent(t.instance, t.vertices.x), fetch_tangent(t.instance, t.vertices.y),
                           fetch_tangent(t.instance, t.vertices.z)) * weights;
        normal = bump_normal(normal, tangent, texel, material.normal_scale);
    }
#endif
    return hit.front ? normal : -normal;
}

/// Stored depth; 0: background, and whatever else the sample holds is undefined.
float fetch_depth(ivec2 position) {
    uint id = fetch_triangle(position);
    return id == NO_TRIANGLE ? 0.0 : hit_triangle(fetch_corners(id), position).depth;
}

uint fetch_material(ivec2 position) {
    return triangle_blocks.items[fetch_triangle(position) >> TRIANGLE_BLOCK_BITS].w; // material
}

vec3 fetch_normal(ivec2 position) {
    Triangle t = fetch_corners(fetch_triangle(position));
    return normal_at(t, hit_triangle(t, position));
}

/// The normal as the packed layout has it: equal words are equal normals.
uint fetch_normal_word(ivec2 position) { return pack_normal(fetch_normal(position)); }

SurfaceSample fetch_surface(ivec2 position) {
    SurfaceSample s;
    s.triangle = fetch_triangle(position);
    Triangle t = fetch_corners(s.triangle);
    Hit hit = hit_triangle(t, position);
    MaterialData material = materials.items[t.material];
    s.normal = normal_at(t, hit);
    s.material = t.material;
    s.depth = s.triangle == NO_TRIANGLE ? 0.0 : hit.depth;
    s.coordinates[0] = s.coordinates[1] = coordinates_at(t, hit, material.uv[0]);
    if (kSecondCoordinates) s.coordinates[1] = coordinates_at(t, hit, material.uv[1]);
    vec4 color = mat3x4(fetch_color(t.vertices.x), fetch_color(t.vertices.y), fetch_color(t.vertices.z)) *
                 weights_of(hit);
    s.color = clamp(color.rgb, 0.0, 1.0);
    return s;
}

SurfacePlane fetch_plane(ivec2 position) {
    uint id = fetch_triangle(position);
    Triangle t = fetch_corners(id);
    Hit hit = hit_triangle(t, position);
    return id == NO_TRIANGLE ? SurfacePlane(0.0, vec2(0.0), t.material)
                             : SurfacePlane(hit.depth, hit.slope, t.material);
}

/// True where the straight continuation of `s` by `offset` samples meets other material or
/// coordinates: a footprint must not reach across (Hollaender et al. 2013, section 4.1).
bool discontinuous(ivec2 position, SurfaceSample s, ivec2 offset) {
    ivec2 other_position = position + offset;
    uint other = fetch_triangle(other_position);
    bool broken = other == NO_TRIANGLE;
    // A loop rather than a branch, whose both sides software drivers execute.
    int others = broken || other == s.triangle ? 0 : 1;
    for (int i = 0; i < others; ++i) {
        Triangle t = fetch_corners(other);
        vec2 uv = coordinates_at(t, hit_triangle(t, other_position), materials.items[t.material].uv[0]).uv;
        broken = t.material != s.material || coordinates_break(s.coordinates[0], uv, offset);
    }
    return broken;
}
