// Which passes shadow and draw particles, in which order. Sources and maths stand in the shaders.
#include "shaders/particles_draw.h"
#include "effects/particles/particles_draw_setup.h"
#include "effects/particles/particles_plan.h"
#include "effects/plan_parts.h"
#include "filters/prefix_sum.h"
#include "filters/radix_sort.h"
#include "shaders/particles_composite.h"
#include "shaders/particles_light.h"
#include "shaders/particles_profile.h"
#include "shaders/particles_tiles.h"

#include <algorithm>
#include <bit>

namespace sfumato {

namespace {

using gpu::ParticleDrawConstants;

constexpr uint32_t facts_words = 96;
constexpr uint32_t profile_side = 256; // of its table; particles_profile.glsl says it too
constexpr uint32_t profile_places = 256;
constexpr uint32_t record_bytes = 32;
constexpr uint32_t tile_side = 16;

Access write(ResourceId resource) {
    return {resource, AccessKind::write, 0, false};
}

// What the passes hand to each other.
struct Drawing {
    Planner& planner;
    const ParticleDrawInputs& in;
    ParticleDrawConstants constants;
    Extent working;
    uint32_t lights = 1;
    uint32_t layers = 16;
    uint32_t side = 256;
    uint32_t room = 1; // for pairs
    bool by_rank = false;
    bool backward = false;
    bool perspective = true;
    ResourceId facts = no_resource, sorted = no_resource, count = no_resource, volume = no_resource;
    ResourceId records = no_resource, extras = no_resource, touched = no_resource, profile_table = no_resource;
    ResourceId ranks = no_resource, pairs = no_resource, ranges = no_resource, dropped = no_resource;
    ResourceId depths = no_resource, far = no_resource, near = no_resource, velocity = no_resource;

    bool has_velocity() const { return in.velocity_output != no_resource; }
    bool has_snapshots() const { return in.parameters.resolution != ParticleResolution::full; }
    bool scatters() const { return in.parameters.scattering_blur > 0.0f; }
    bool has_profile() const { return drawn_profile(in.parameters) != ParticleProfile::sphere; }
    uint32_t profile() const { return static_cast<uint32_t>(drawn_profile(in.parameters)); }
    uint32_t view() const { return static_cast<uint32_t>(in.parameters.debug_view); }
    uint32_t tiles() const { return blocks_of(working.width, tile_side) * blocks_of(working.height, tile_side); }
    ResourceId words(const char* name, uint64_t count_of) const { return planner.buffer(name, 4 * count_of); }

    Pass& pass(const char* name, const Shader& shader, std::vector<uint32_t> specialization,
               std::vector<Access> accesses, const Dispatch& dispatch) const {
        Pass& pass = planner.pass(name, shader);
        pass.specialization = std::move(specialization);
        pass.accesses = std::move(accesses);
        pass.dispatch = dispatch;
        pass.constants = constants_of(constants);
        return pass;
    }
    Dispatch groups(uint32_t elements, uint32_t block) const {
        return dispatch_groups(planner, blocks_of(elements, block));
    }
};

void clear(const Drawing& d, const char* name, ResourceId buffer, uint64_t words) {
    Pass& pass = d.planner.pass(name, shaders::particles_draw::clear);
    pass.accesses = {write_buffer(buffer)};
    pass.dispatch = d.groups(static_cast<uint32_t>(words), 256 * 16);
}

// The profile's table, three levels a pass, and the mass of its parts.
void plan_profile(Drawing& d) {
    namespace shader = shaders::particles_profile;
    const bool is_noise = drawn_profile(d.in.parameters) == ParticleProfile::noise;
    d.profile_table = d.planner.transient("profile", VK_FORMAT_R16_SFLOAT, {profile_side, profile_side}, 6);
    const auto level = [&](uint32_t mip) { return Access{d.profile_table, AccessKind::write, mip, false}; };
    const auto levels = [&](uint32_t source, const Access& image, uint32_t mip) {
        d.pass("profile", shader::table, {source}, {image, level(mip), level(mip + 1), level(mip + 2)},
               {DispatchKind::groups, d.profile_table, mip, 0, {16, 16}});
    };
    levels(d.profile(), read(is_noise ? no_resource : d.in.profile), 0);
    levels(0, {d.profile_table, AccessKind::fetch, 2}, 3);
    d.pass("weigh profile", shader::weigh, {is_noise}, {{d.profile_table, AccessKind::fetch, 1}, write_buffer(d.facts)},
           dispatch_groups(d.planner, is_noise ? profile_places : 1));
}

// Who is alive and in view, and the particles' numbers in the order of drawing.
void plan_order(Drawing& d) {
    namespace shader = shaders::particles_draw;
    const uint32_t capacity = d.in.capacity;
    d.facts = d.words("facts", facts_words + (d.has_profile() ? profile_places : 0));
    Pass& begin = d.planner.pass("begin", shader::begin);
    begin.accesses = {write_buffer(d.facts)};
    begin.dispatch = dispatch_groups(d.planner, 1);
    if (d.has_profile())
        plan_profile(d);
    const ResourceId flags = d.words("flags", capacity);
    d.pass("measure", shader::measure, {d.lights, !d.by_rank},
           {read_buffer(d.in.sprites), write_buffer(d.facts), write_buffer(flags)}, d.groups(capacity, 2048));
    d.pass("settle", shader::settle, {d.lights}, {write_buffer(d.facts)}, dispatch_groups(d.planner, 1));
    const PrefixSum places = plan_prefix_sum(d.planner, flags, {.capacity = capacity}, PrefixSumKind::exclusive);
    const ResourceId keys = d.words("depth keys", capacity), values = d.words("particles", capacity);
    const uint32_t bits = key_bits(d.in.parameters);
    d.pass("key", shader::key, {bits == 32},
           {read_buffer(d.in.sprites), read_buffer(d.facts), read_buffer(flags), read_buffer(places.sums),
            write_buffer(keys), write_buffer(values)},
           d.groups(capacity, 256));
    d.count = places.total;
    d.sorted =
        plan_radix_sort(d.planner, keys, values, {places.total, 0, capacity}, bits, {.overwrite_input = true}).values;
}

// Layer by layer, what is left of the light is blurred before it goes on: these passes wait for each other.
void plan_scattering(Drawing& d) {
    for (uint32_t light = 0; light < d.lights; ++light) {
        ResourceId before = d.words("light", uint64_t{d.side} * d.side);
        ResourceId after = d.words("light", uint64_t{d.side} * d.side);
        clear(d, "clear light", before, uint64_t{d.side} * d.side);
        for (uint32_t layer = 0; layer <= d.layers; ++layer) {
            d.constants.step_light = light;
            d.constants.step_layer = layer;
            const uint32_t across = blocks_of(d.side, 16);
            const ResourceId shape = d.planner.transient("workgroups", VK_FORMAT_R8G8B8A8_UNORM, {across, across});
            d.pass("scatter", shaders::particles_light::scatter, {},
                   {read_buffer(d.facts), write_buffer(d.volume), read_buffer(before), write_buffer(after)},
                   {DispatchKind::groups, shape, 0, 0, {1, 1}});
            std::swap(before, after);
        }
    }
}

// Optical depth behind each layer of each light.
void plan_light(Drawing& d) {
    namespace shader = shaders::particles_light;
    const uint64_t words = uint64_t{d.constants.area} * d.constants.planes * d.lights;
    d.volume = d.words("shadow buffer", words);
    clear(d, "clear shadow", d.volume, words);
    // The sorted numbers are only read where slices go by rank.
    d.pass("splat", shader::splat, {d.lights, d.by_rank},
           {read_buffer(d.in.sprites), read_buffer(d.facts), read_buffer(d.sorted), read_buffer(d.count),
            write_buffer(d.volume)},
           d.groups(d.in.capacity, 128));
    if (d.scatters())
        plan_scattering(d);
    d.pass("sum layers", shader::sum, {d.lights, d.scatters()}, {read_buffer(d.facts), write_buffer(d.volume)},
           d.groups(d.constants.area / 4 * d.lights, 64));
}

// Lit records in the order of drawing, and pairs of tile and particle sorted by tile.
void plan_tiles(Drawing& d) {
    const uint32_t capacity = d.in.capacity;
    d.records = d.planner.buffer("records", uint64_t{capacity} * record_bytes);
    d.touched = d.words("tiles touched", capacity);
    const uint32_t extras = (d.has_velocity() ? 1 : 0) + (d.has_profile() ? 1 : 0);
    d.extras = d.words("velocities and patterns", std::max(uint64_t{capacity} * extras, uint64_t{1}));
    d.pass("light and record", shaders::particles_draw::record,
           {d.lights, d.by_rank, d.in.shadow_map != no_resource, d.view() <= 2 ? d.view() : 0, d.has_velocity(),
            d.scatters(), d.profile()},
           {read_buffer(d.in.sprites), read_buffer(d.facts), read_buffer(d.sorted), read_buffer(d.count),
            read_buffer(d.volume), read(d.in.shadow_map), write_buffer(d.records), write_buffer(d.touched),
            write_buffer(d.extras)},
           d.groups(capacity, 256));
    const PrefixSum places = plan_prefix_sum(d.planner, d.touched, {.capacity = capacity}, PrefixSumKind::exclusive);
    const ResourceId tiles = d.words("tiles", d.room), ranks = d.words("ranks", d.room);
    const bool counts_dropped = d.in.parameters.debug_view == ParticleView::overflow;
    d.dropped = d.words("dropped", counts_dropped ? d.tiles() : 1);
    d.pairs = d.words("pairs", 2);
    clear(d, "clear dropped", d.dropped, counts_dropped ? d.tiles() : 1);
    namespace shader = shaders::particles_tiles;
    d.pass("emit pairs", shader::emit, {d.backward, counts_dropped},
           {read_buffer(d.records), read_buffer(d.touched), read_buffer(places.sums), write_buffer(tiles),
            write_buffer(ranks), write_buffer(d.pairs), write_buffer(d.dropped)},
           d.groups(capacity, 256));
    const auto bits = static_cast<uint32_t>(std::bit_width(d.tiles() - 1));
    const SortedPairs sorted =
        plan_radix_sort(d.planner, tiles, ranks, {d.pairs, 0, d.room}, std::max(bits, 1u), {.overwrite_input = true});
    d.ranks = sorted.values;
    d.ranges = d.words("tile ranges", 2 * uint64_t{d.tiles()});
    clear(d, "clear ranges", d.ranges, 2 * uint64_t{d.tiles()});
    d.pass("tile ranges", shader::range, {}, {read_buffer(sorted.keys), read_buffer(d.pairs), write_buffer(d.ranges)},
           d.groups(d.room, 1024));
}

void plan_draw(Drawing& d) {
    const bool device_depth = d.in.frame.depth_kind == DepthKind::device;
    const uint32_t factor = resolution_factor(d.in.parameters.resolution);
    d.depths = d.planner.transient("block depths", VK_FORMAT_R32G32_SFLOAT, d.working);
    d.pass("depth", shaders::particles_composite::depth, {device_depth, factor}, {read(d.in.depth), write(d.depths)},
           {DispatchKind::texels, d.depths});
    d.far = d.planner.transient("particles", VK_FORMAT_R16G16B16A16_SFLOAT, d.working);
    d.near = d.planner.transient("particles before edges", VK_FORMAT_R16G16B16A16_SFLOAT,
                                 d.has_snapshots() ? d.working : Extent{1, 1});
    d.velocity = d.planner.transient("particles' velocity", VK_FORMAT_R16G16_SFLOAT,
                                     d.has_velocity() ? d.working : Extent{1, 1});
    d.pass("draw", shaders::particles_tiles::draw,
           {d.backward, d.has_snapshots(), d.has_velocity(), d.perspective, d.profile()},
           {read_buffer(d.ranges),
            read_buffer(d.ranks),
            read_buffer(d.records),
            read_buffer(d.extras),
            read(d.depths),
            write(d.far),
            write(d.near),
            write(d.velocity),
            {d.profile_table, AccessKind::filter, all_mips}},
           {DispatchKind::groups, d.far, 0, 0, {tile_side, tile_side}});
}

void plan_composite(const Drawing& d) {
    const auto output = [&](ResourceId image) {
        return write(image != no_resource ? image : d.planner.transient("not written", VK_FORMAT_R32_SFLOAT, {1, 1}));
    };
    const ParticleDrawInputs& in = d.in;
    const ResourceId near = d.has_snapshots() ? d.near : d.far;
    d.pass("composite", shaders::particles_composite::composite,
           {in.frame.depth_kind == DepthKind::device, resolution_factor(in.parameters.resolution), d.by_rank,
            in.parameters.scene_shadow > 0.0f, in.direct != no_resource, d.has_velocity(),
            in.transmittance != no_resource, d.view(), d.perspective, d.scatters()},
           {read(in.colour), read(in.depth), read(in.direct), read(in.velocity), read(d.depths), read(d.far),
            read(near), read(d.has_velocity() ? d.velocity : no_resource), read_buffer(d.facts), read_buffer(d.volume),
            read_buffer(d.ranges), read_buffer(d.dropped), write(in.output), output(in.velocity_output),
            output(in.transmittance)},
           {DispatchKind::texels, in.output});
    if (in.statistics == no_resource)
        return;
    Pass& report = d.planner.pass("report", shaders::particles_composite::report);
    report.accesses = {read_buffer(d.facts), read_buffer(d.pairs), write_buffer(in.statistics)};
    report.dispatch = dispatch_groups(d.planner, 1);
}

} // namespace

void plan_particle_draw(Planner& planner, const ParticleDrawInputs& in) {
    const ParticleVolumeParameters& p = in.parameters;
    Drawing d{.planner = planner,
              .in = in,
              .constants = particle_draw_constants(in.frame, p, in.extent),
              .working = working_extent(in.extent, p.resolution)};
    d.lights = static_cast<uint32_t>(std::clamp(in.frame.lights.size(), size_t{1}, most_lights));
    d.layers = layer_count(p);
    d.side = static_cast<uint32_t>(p.shadow_resolution);
    // A few particles may be large: every tile may be touched by a number of them whatever the count.
    const uint64_t wanted = uint64_t{in.capacity} * static_cast<uint32_t>(p.pairs_per_particle) + 16 * d.tiles();
    d.room = static_cast<uint32_t>(std::min<uint64_t>(wanted, most_pairs));
    d.by_rank = p.mode == ParticleMode::half_angle;
    d.backward = draws_backward(in.frame, p);
    d.perspective = in.frame.camera->projection[11] != 0.0f;
    d.constants.capacity = in.capacity;
    d.constants.room = d.room;
    d.constants.layers = d.layers;
    d.constants.side = d.side;
    d.constants.area = 4 * blocks_of(d.side * d.side, 4);
    d.constants.planes = 4 * blocks_of(d.layers, 4);
    plan_order(d);
    plan_light(d);
    plan_tiles(d);
    plan_draw(d);
    plan_composite(d);
}

} // namespace sfumato
