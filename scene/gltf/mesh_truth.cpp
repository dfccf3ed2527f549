// Ambient occlusion on meshes. Samples and definition are those of occlusion_truth.comp: the same seed gives the same
// directions, so that both truths can be compared ray by ray.
#include "scene/gltf/mesh_truth.h"
#include "scene/vec3.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <system_error>
#include <thread>
#include <type_traits>

namespace sfumato::scene {
namespace {

struct Mask {
    const Texture* texture = nullptr; // may be absent
    float cutoff = 0.0f;
};

struct SurfaceKind {
    bool is_masked = false, is_double_sided = true;
    Mask mask;
};

float alpha_at(const Texture& texture, int64_t x, int64_t y) {
    const auto wrapped = [](int64_t at, uint32_t size, bool repeats) {
        const auto n = static_cast<int64_t>(size);
        return static_cast<size_t>(repeats ? (at % n + n) % n : std::clamp<int64_t>(at, 0, n - 1));
    };
    const size_t column = wrapped(x, texture.width, texture.repeats_u);
    const size_t row = wrapped(y, texture.height, texture.repeats_v);
    return static_cast<float>(texture.rgba[(row * texture.width + column) * 4 + 3]) / 255.0f;
}

// Of the finest level; texture coordinates beyond any sense count as 0.
float sampled_alpha(const Texture& texture, double u, double v) {
    const double x = u * texture.width - 0.5, y = v * texture.height - 0.5;
    if (!(std::abs(x) < 1e15 && std::abs(y) < 1e15))
        return alpha_at(texture, 0, 0);
    if (texture.is_nearest)
        return alpha_at(texture, std::llround(x), std::llround(y));
    const double left = std::floor(x), top = std::floor(y);
    const auto column = static_cast<int64_t>(left), row = static_cast<int64_t>(top);
    const auto s = static_cast<float>(x - left), t = static_cast<float>(y - top);
    return std::lerp(std::lerp(alpha_at(texture, column, row), alpha_at(texture, column + 1, row), s),
                     std::lerp(alpha_at(texture, column, row + 1), alpha_at(texture, column + 1, row + 1), s), t);
}

uint32_t mixed(uint32_t x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

uint32_t reversed(uint32_t x) {
    x = (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
    x = (x & 0x00ff00ffu) << 8 | (x >> 8 & 0x00ff00ffu);
    return x << 16 | x >> 16;
}

// Owen's scrambling of a number whose bits are in reverse order.
uint32_t scrambled_reversed(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

uint32_t sobol_reversed(uint32_t index) {
    uint32_t result = 0;
    for (uint32_t column = 1; index != 0; index >>= 1, column ^= column << 1)
        if ((index & 1u) != 0)
            result ^= column;
    return result;
}

std::array<double, 2> sample_point(uint32_t index, uint32_t seed) {
    const uint32_t x = reversed(scrambled_reversed(index, mixed(seed ^ 0x9e3779b9u)));
    const uint32_t y = reversed(scrambled_reversed(sobol_reversed(index), mixed(seed ^ 0x85ebca6bu)));
    return {(x >> 8) / 16777216.0, (y >> 8) / 16777216.0};
}

double falloff(Falloff kind, double t) {
    const double square = t * t;
    switch (kind) {
    case Falloff::linear:
        return 1.0 - t;
    case Falloff::quadratic:
        return 1.0 - square;
    case Falloff::sao:
        return (1.0 - square) * (1.0 - square) * (1.0 - square);
    case Falloff::contact:
        return (1.0 - t) * (1.0 - t);
    case Falloff::wide:
        return 1.0 - square * square;
    case Falloff::hard:
        break;
    }
    return 1.0;
}

// Two vectors that make a right-handed basis with n (Duff et al., JCGT 2017).
void basis(Vec3 n, Vec3& u, Vec3& v) {
    const double side = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (side + n.z), b = n.x * n.y * a;
    u = {1.0 + side * n.x * n.x * a, side * b, -side * n.x};
    v = {b, side + n.y * n.y * a, -n.y};
}

// The camera in double, and the rays of its pixels.
struct Eye {
    Camera camera;
    Extent extent;
    double nearest = 0.0, farthest = std::numeric_limits<double>::infinity(); // view depths

    double p(size_t i) const { return static_cast<double>(camera.projection[i]); }
    double m(size_t i) const { return static_cast<double>(camera.world_to_view[i]); }

    Vec3 to_world_direction(Vec3 d) const {
        return {m(0) * d.x + m(1) * d.y + m(2) * d.z, m(4) * d.x + m(5) * d.y + m(6) * d.z,
                m(8) * d.x + m(9) * d.y + m(10) * d.z};
    }
    Vec3 to_view_direction(Vec3 d) const {
        return {m(0) * d.x + m(4) * d.y + m(8) * d.z, m(1) * d.x + m(5) * d.y + m(9) * d.z,
                m(2) * d.x + m(6) * d.y + m(10) * d.z};
    }
    // What is seen at a pixel's centre at a view depth, in world space.
    Vec3 point(uint32_t x, uint32_t y, double depth) const {
        const double ndc_x = (x + 0.5) / extent.width * 2.0 - 1.0, ndc_y = (y + 0.5) / extent.height * 2.0 - 1.0;
        const double w = p(15) - p(11) * depth;
        const Vec3 view = {(ndc_x * w + p(8) * depth - p(12)) / p(0), (ndc_y * w + p(9) * depth - p(13)) / p(5),
                           -depth};
        return to_world_direction(view - Vec3{m(12), m(13), m(14)});
    }
};

// Where the projection's depth becomes 0 and 1.
void set_range(Eye& eye) {
    const double at_zero = eye.p(14) / eye.p(10), at_one = (eye.p(14) - eye.p(15)) / (eye.p(10) - eye.p(11));
    const bool zero_counts = std::isfinite(at_zero) && at_zero >= 0.0,
               one_counts = std::isfinite(at_one) && at_one >= 0;
    if (zero_counts && one_counts) {
        eye.nearest = std::min(at_zero, at_one);
        eye.farthest = std::max(at_zero, at_one);
    } else if (zero_counts || one_counts) {
        eye.nearest = zero_counts ? at_zero : at_one; // the other lies at infinity
    }
}

// Releases what Embree counts references of.
template <auto release>
struct Release {
    template <class T>
    void operator()(T* handle) const {
        release(handle);
    }
};
template <class Handle, auto release>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Release<release>>;

struct RayContext {
    RTCIntersectContext embree;
    bool is_camera = false;
};

struct Surface {
    bool exists = false;
    double depth = 0.0;
    Vec3 position, normal, plane_normal; // world; both normals towards the camera
};

class Tracer {
  public:
    Tracer(const Model& model, const TriangleMesh& mesh, const Eye& eye, const OcclusionTruth& options)
        : model_(model), mesh_(mesh), eye_(eye), options_(options) {}

    Result<void> build();
    void trace_row(uint32_t y, MeshTruth& truth) const;

  private:
    static void filter(const RTCFilterFunctionNArguments* arguments);
    bool lets_through(const RTCRayHit& hit, bool is_camera) const;
    const SurfaceKind& kind_of(uint32_t triangle) const;
    Vec3 vertex(uint32_t triangle, uint32_t corner) const;
    Surface camera_hit(uint32_t x, uint32_t y) const;
    double occluder_distance(Vec3 origin, Vec3 direction) const;
    void trace_pixel(const Surface& surface, uint32_t x, uint32_t y, size_t pixel, MeshTruth& truth) const;

    const Model& model_;
    const TriangleMesh& mesh_;
    const Eye& eye_;
    const OcclusionTruth& options_;
    std::vector<SurfaceKind> kinds_; // of each material
    Owned<RTCDevice, rtcReleaseDevice> device_;
    Owned<RTCScene, rtcReleaseScene> scene_;
};

SurfaceKind kind_of_material(const Model& model, const ModelMaterial& material) {
    SurfaceKind kind;
    kind.is_double_sided = material.double_sided;
    kind.is_masked = material.alpha_mode != AlphaMode::opaque;
    kind.mask.cutoff = material.alpha_mode == AlphaMode::mask ? material.alpha_cutoff : 0.5f;
    if (material.base_colour_texture != none)
        kind.mask.texture = &model.textures[material.base_colour_texture];
    return kind;
}

Result<void> Tracer::build() {
    for (const ModelMaterial& material : model_.materials)
        kinds_.push_back(kind_of_material(model_, material));
    // One thread builds the tree in the same way every time.
    device_.reset(rtcNewDevice("threads=1"));
    if (!device_)
        return Error{ErrorCode::internal, "Embree does not start: error " + std::to_string(rtcGetDeviceError(nullptr))};
    scene_.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST); // no ray slips through an edge
    const Owned<RTCGeometry, rtcReleaseGeometry> geometry(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE));
    const size_t triangles = mesh_.indices.size() / 3;
    if (triangles > 0) {
        void* positions = rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                                  mesh_.positions.size());
        void* indices =
            rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles);
        if (!positions || !indices)
            return Error{ErrorCode::out_of_memory,
                         "not enough memory to trace " + std::to_string(triangles) + " triangles"};
        std::memcpy(positions, mesh_.positions.data(), mesh_.positions.size() * 12);
        std::memcpy(indices, mesh_.indices.data(), triangles * 12);
        rtcSetGeometryUserData(geometry.get(), const_cast<Tracer*>(this));
        rtcSetGeometryIntersectFilterFunction(geometry.get(), filter);
        rtcCommitGeometry(geometry.get());
        rtcAttachGeometry(scene_.get(), geometry.get());
    }
    rtcCommitScene(scene_.get());
    if (const RTCError error = rtcGetDeviceError(device_.get()); error != RTC_ERROR_NONE)
        return Error{error == RTC_ERROR_OUT_OF_MEMORY ? ErrorCode::out_of_memory : ErrorCode::internal,
                     "Embree cannot build its tree: error " + std::to_string(error)};
    return {};
}

const SurfaceKind& Tracer::kind_of(uint32_t triangle) const {
    const TriangleMesh::Source& source = mesh_.sources[triangle];
    return kinds_[model_.meshes[model_.nodes[source.node].mesh].parts[source.part].material];
}

// One ray at a time.
void Tracer::filter(const RTCFilterFunctionNArguments* arguments) {
    const Tracer& tracer = *static_cast<const Tracer*>(arguments->geometryUserPtr);
    const auto* context = reinterpret_cast<const RayContext*>(arguments->context);
    RTCRayHit found;
    found.ray = rtcGetRayFromRayN(arguments->ray, 1, 0);
    found.hit = rtcGetHitFromHitN(arguments->hit, 1, 0);
    if (tracer.lets_through(found, context->is_camera))
        arguments->valid[0] = 0;
}

bool Tracer::lets_through(const RTCRayHit& found, bool is_camera) const {
    const uint32_t triangle = found.hit.primID;
    const SurfaceKind& kind = kind_of(triangle);
    // Embree's normal is that of counter-clockwise triangles.
    const float facing =
        found.hit.Ng_x * found.ray.dir_x + found.hit.Ng_y * found.ray.dir_y + found.hit.Ng_z * found.ray.dir_z;
    if (is_camera && !kind.is_double_sided && facing > 0.0f)
        return true;
    if (!kind.is_masked)
        return false;
    const double shares[3] = {1.0 - static_cast<double>(found.hit.u) - static_cast<double>(found.hit.v),
                              static_cast<double>(found.hit.u), static_cast<double>(found.hit.v)};
    double u = 0.0, v = 0.0, alpha = 0.0;
    for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t index = mesh_.indices[triangle * 3 + k];
        u += shares[k] * static_cast<double>(mesh_.texcoords[index][0]);
        v += shares[k] * static_cast<double>(mesh_.texcoords[index][1]);
        alpha += shares[k] * static_cast<double>(mesh_.opacities[index]);
    }
    if (kind.mask.texture)
        alpha *= static_cast<double>(sampled_alpha(*kind.mask.texture, u, v));
    return alpha < static_cast<double>(kind.mask.cutoff);
}

Vec3 vec3_of(const std::array<float, 3>& v) {
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

Vec3 Tracer::vertex(uint32_t triangle, uint32_t corner) const {
    return vec3_of(mesh_.positions[mesh_.indices[triangle * 3 + corner]]);
}

RTCRayHit cast(RTCScene scene, Vec3 origin, Vec3 direction, double nearest, double farthest, bool is_camera) {
    RTCRayHit ray{};
    ray.ray.org_x = static_cast<float>(origin.x);
    ray.ray.org_y = static_cast<float>(origin.y);
    ray.ray.org_z = static_cast<float>(origin.z);
    ray.ray.dir_x = static_cast<float>(direction.x);
    ray.ray.dir_y = static_cast<float>(direction.y);
    ray.ray.dir_z = static_cast<float>(direction.z);
    ray.ray.tnear = static_cast<float>(nearest);
    ray.ray.tfar = static_cast<float>(farthest);
    ray.ray.mask = ~0u;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RayContext context;
    rtcInitIntersectContext(&context.embree);
    context.is_camera = is_camera;
    rtcIntersect1(scene, &context.embree, &ray);
    return ray;
}

Surface Tracer::camera_hit(uint32_t x, uint32_t y) const {
    // Along this direction the ray's parameter is the view depth.
    const Vec3 origin = eye_.point(x, y, 0.0), direction = eye_.point(x, y, 1.0) - origin;
    const RTCRayHit found = cast(scene_.get(), origin, direction, eye_.nearest, eye_.farthest, true);
    Surface surface;
    if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return surface;
    const uint32_t triangle = found.hit.primID;
    const Vec3 a = vertex(triangle, 0), b = vertex(triangle, 1), c = vertex(triangle, 2);
    const Vec3 across = cross(b - a, c - a);
    const double length = std::sqrt(dot(across, across));
    const double facing = dot(across, direction);
    if (!(length > 0.0) || facing == 0.0)
        return surface;
    surface.exists = true;
    surface.plane_normal = across * ((facing > 0.0 ? -1.0 : 1.0) / length);
    // Again in double, so that flat views far away keep their precision.
    surface.depth = dot(a - origin, across) / facing;
    surface.position = origin + direction * surface.depth;
    const double u = static_cast<double>(found.hit.u), v = static_cast<double>(found.hit.v);
    const auto normal_at = [&](uint32_t corner) {
        return vec3_of(mesh_.normals[mesh_.indices[triangle * 3 + corner]]);
    };
    const Vec3 normal = normal_at(0) * (1.0 - u - v) + normal_at(1) * u + normal_at(2) * v;
    // Behind a double-sided surface its vertices' normals turn with its plane's.
    const double side = facing > 0.0 ? -1.0 : 1.0;
    surface.normal = dot(normal, normal) > 1e-20 ? normalised(normal) * side : surface.plane_normal;
    if (dot(surface.normal, direction) > 0.0) // of a triangle at the outline, bent beyond it
        surface.normal = surface.plane_normal;
    return surface;
}

// At most the radius.
double Tracer::occluder_distance(Vec3 origin, Vec3 direction) const {
    const RTCRayHit found = cast(scene_.get(), origin, direction, 0.0, options_.radius, false);
    return found.hit.geomID == RTC_INVALID_GEOMETRY_ID ? options_.radius : static_cast<double>(found.ray.tfar);
}

void Tracer::trace_pixel(const Surface& surface, uint32_t x, uint32_t y, size_t pixel, MeshTruth& truth) const {
    const uint32_t seed = mixed(x + mixed(y + mixed(options_.seed)));
    Vec3 u, v, open;
    basis(surface.normal, u, v);
    const Vec3 p = surface.position;
    // Rounded to float, the origin must not lie below the surface.
    const double lift = 2e-6 * std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z), 1e-2 * options_.radius});
    const Vec3 origin = p + surface.plane_normal * lift;
    double occluded = 0.0;
    for (int i = 0; i < options_.rays; ++i) {
        const auto point = sample_point(static_cast<uint32_t>(i), seed);
        const double angle = 2.0 * std::numbers::pi * point[1], side = std::sqrt(point[0]);
        const Vec3 direction =
            (u * std::cos(angle) + v * std::sin(angle)) * side + surface.normal * std::sqrt(1.0 - point[0]);
        const bool is_below = dot(direction, surface.plane_normal) <= 0.0;
        const double t = is_below ? 0.0 : occluder_distance(origin, direction) / options_.radius;
        const double occlusion = t < 1.0 ? falloff(options_.falloff, t) : 0.0;
        open = open + direction * (1.0 - occlusion);
        occluded += occlusion;
    }
    const double visibility = std::clamp(1.0 - occluded / options_.rays, 0.0, 1.0);
    const Vec3 bent = normalised(eye_.to_view_direction(dot(open, open) > 1e-12 ? open : surface.normal));
    truth.visibility[pixel] = static_cast<float>(visibility);
    truth.bent_normal[pixel] = {static_cast<float>(bent.x), static_cast<float>(bent.y), static_cast<float>(bent.z),
                                static_cast<float>(visibility)};
}

void Tracer::trace_row(uint32_t y, MeshTruth& truth) const {
    for (uint32_t x = 0; x < eye_.extent.width; ++x) {
        const Surface surface = camera_hit(x, y);
        if (!surface.exists)
            continue;
        const size_t pixel = size_t{y} * eye_.extent.width + x;
        const Vec3 normal = normalised(eye_.to_view_direction(surface.normal));
        truth.depth[pixel] = static_cast<float>(surface.depth);
        truth.normal[pixel] = {static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z),
                               0.0f};
        trace_pixel(surface, x, y, pixel, truth);
    }
}

Result<void> check(const TriangleMesh& mesh, const Camera& camera, Extent extent, const OcclusionTruth& options) {
    const auto refuse = [](const std::string& message) { return Error{ErrorCode::invalid_argument, message}; };
    if (extent.width < 1 || extent.height < 1 || extent.width > 16384 || extent.height > 16384)
        return refuse("the truth's extent is " + std::to_string(extent.width) + "×" + std::to_string(extent.height) +
                      "; sides from 1 to 16384 are allowed");
    if (options.rays < 1 || options.rays > 65536)
        return refuse("occlusion rays is " + std::to_string(options.rays) + "; 1 to 65536 are allowed");
    if (!(options.radius > 0.0 && std::isfinite(options.radius)))
        return refuse("the occlusion radius is " + std::to_string(options.radius) + "; it must be above 0");
    for (const Matrix4* matrix : {&camera.world_to_view, &camera.projection})
        for (const float value : *matrix)
            if (!std::isfinite(value))
                return refuse("the camera has a matrix that is not finite");
    const Matrix4& p = camera.projection;
    if (p[0] == 0.0f || p[5] == 0.0f || (p[11] == 0.0f) == (p[15] == 0.0f))
        return refuse("the camera's projection is neither perspective nor orthographic");
    if (mesh.sources.size() * 3 != mesh.indices.size() || mesh.normals.size() != mesh.positions.size() ||
        mesh.texcoords.size() != mesh.positions.size() || mesh.opacities.size() != mesh.positions.size())
        return refuse("the triangles are not as pose_triangles gives them");
    return {};
}

Result<MeshTruth> trace(const Model& model, const TriangleMesh& mesh, const Eye& eye, const OcclusionTruth& options) {
    Tracer tracer(model, mesh, eye, options);
    if (const auto built = tracer.build(); !built)
        return built.error();
    const Extent extent = eye.extent;
    const size_t pixels = size_t{extent.width} * extent.height;
    MeshTruth truth{extent, std::vector<float>(pixels, sky_depth), std::vector<std::array<float, 4>>(pixels),
                    std::vector<float>(pixels, 1.0f), std::vector<std::array<float, 4>>(pixels, {0, 0, 0, 1})};
    // A pixel depends on nothing but itself: the order of the rows does not matter.
    std::atomic<uint32_t> next{0};
    const auto work = [&] {
        for (uint32_t y = next++; y < extent.height; y = next++)
            tracer.trace_row(y, truth);
    };
    std::vector<std::jthread> helpers;
    try {
        for (unsigned i = 1; i < std::min(std::thread::hardware_concurrency(), 64u); ++i)
            helpers.emplace_back(work);
    } catch (const std::system_error&) { // then with those that there are
    }
    work();
    helpers.clear(); // joins
    return truth;
}

} // namespace

Result<MeshTruth> trace_occlusion(const Model& model, const TriangleMesh& mesh, const Camera& camera, Extent extent,
                                  const OcclusionTruth& options) {
    if (const auto checked = check(mesh, camera, extent, options); !checked)
        return checked.error();
    Eye eye{camera, extent};
    set_range(eye);
    try {
        return trace(model, mesh, eye, options);
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::out_of_memory, "not enough memory to trace rays against the model"};
    }
}

} // namespace sfumato::scene
