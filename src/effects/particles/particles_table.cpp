// The parameters, presets, images and buffers of particles, each described once.
#include "sfumato/effects/particles.h"

#include "effects/particles/particles_plan.h"

namespace sfumato {

namespace {

using P = ParticleVolumeParameters;

constexpr const char* emitters[] = {"point", "sphere", "box", "disc"};
constexpr const char* collisions[] = {"none", "depth", "analytic", "both"};
constexpr const char* modes[] = {"light-volume", "half-angle"};
constexpr const char* resolutions[] = {"full", "half", "quarter"};
constexpr const char* profiles[] = {"sphere", "noise", "texture"};
constexpr const char* sort_bits[] = {"16", "24", "32"};
constexpr const char* views[] = {"none", "order", "slices", "shadow", "layers", "tiles", "overflow"};

constexpr ParameterInfo rows[] = {
    // Emission.
    parameter<&P::count>("count", "", 1, most_particles,
                         "Room for particles: the oldest make way for new ones when it is used up.",
                         parameter_logarithmic),
    parameter<&P::seed>("seed", "", 0, 65535, "Another one gives another cloud of the same kind."),
    parameter<&P::emitter>("emitter", emitters,
                           "Where particles are born: at a point, anywhere in a sphere, box or level disc."),
    parameter<&P::position_x>("position_x", "m", -10000.0, 10000.0, "Middle of the emitter, world space."),
    parameter<&P::position_y>("position_y", "m", -10000.0, 10000.0, "Middle of the emitter, world space."),
    parameter<&P::position_z>("position_z", "m", -10000.0, 10000.0, "Middle of the emitter, world space."),
    parameter<&P::emitter_size>("emitter_size", "m", 0.0, 1000.0,
                                "Radius of the sphere or disc, half the side of the box."),
    parameter<&P::direction_azimuth>("direction_azimuth", "°", -180.0, 180.0,
                                     "Where particles start to, from +z towards +x."),
    parameter<&P::direction_elevation>("direction_elevation", "°", -90.0, 90.0,
                                       "Where particles start to, above the horizon."),
    parameter<&P::spread>("spread", "°", 0.0, 180.0, "Half angle of the cone of starting directions; 180 is all."),
    parameter<&P::speed>("speed", "m/s", 0.0, 1000.0, "Speed at the start."),
    parameter<&P::rate>("rate", "1/s", 0.0, 4000000.0, "Particles born in a second."),
    parameter<&P::burst>("burst", "", 0, most_particles, "Particles born at once when the simulation starts."),
    parameter<&P::lifetime>("lifetime", "s", 0.01, 1000.0, "Mean life of a particle.", parameter_logarithmic),
    parameter<&P::lifetime_variation>("lifetime_variation", "of the lifetime", 0.0, 1.0,
                                      "How much longer or shorter a life may be."),
    parameter<&P::warm_up>("warm_up", "s", 0.0, 60.0, "Simulated before the first frame after a reset."),
    parameter<&P::time_scale>("time_scale", "", 0.0, 10.0, "Speed of the simulation; 0 stands still."),
    // Forces.
    parameter<&P::gravity>("gravity", "m/s²", -50.0, 50.0, "Pull downwards; below 0 lifts, as hot gas does."),
    parameter<&P::drag>("drag", "1/s", 0.0, 100.0,
                        "How fast particles take on the velocity of the air, which wind and curl noise make."),
    parameter<&P::wind_x>("wind_x", "m/s", -200.0, 200.0, "Velocity of the air, world space."),
    parameter<&P::wind_y>("wind_y", "m/s", -200.0, 200.0, "Velocity of the air, world space."),
    parameter<&P::wind_z>("wind_z", "m/s", -200.0, 200.0, "Velocity of the air, world space."),
    parameter<&P::curl_strength>("curl_strength", "m/s", 0.0, 100.0,
                                 "Typical speed of the turbulence that is added to the wind."),
    parameter<&P::curl_scale>("curl_scale", "m", 0.01, 1000.0, "Size of the largest eddies.", parameter_logarithmic),
    parameter<&P::curl_speed>("curl_speed", "1/s", 0.0, 20.0, "How fast eddies change, in sizes a second."),
    parameter<&P::curl_octaves>("curl_octaves", "", 1, 4, "Sizes of eddies, each half as large as the one before."),
    parameter<&P::attractor_x>("attractor_x", "m", -10000.0, 10000.0, "Place of the attractor, world space."),
    parameter<&P::attractor_y>("attractor_y", "m", -10000.0, 10000.0, "Place of the attractor, world space."),
    parameter<&P::attractor_z>("attractor_z", "m", -10000.0, 10000.0, "Place of the attractor, world space."),
    parameter<&P::attractor_strength>(
        "attractor_strength", "m²/s²", -1000.0, 1000.0,
        "Pull of the attractor at distance r: strength · r / (r² + 1 m²); below 0 pushes away."),
    parameter<&P::collision>("collision", collisions,
                             "What particles bounce off: nothing, the visible scene (depth), the frame's colliders "
                             "(analytic), or both."),
    parameter<&P::collision_thickness>("collision_thickness", "m", 0.0, 100.0,
                                       "Depth that visible surfaces are taken to have."),
    parameter<&P::bounce>("bounce", "", 0.0, 1.0, "Share of the speed against a surface that a bounce gives back."),
    parameter<&P::friction>("friction", "", 0.0, 1.0, "Share of the speed along a surface that a bounce takes."),
    // Look.
    parameter<&P::radius_start>("radius_start", "m", 0.001, 100.0, "Radius at birth.", parameter_logarithmic),
    parameter<&P::radius_end>("radius_end", "m", 0.001, 100.0, "Radius at the end of life.", parameter_logarithmic),
    parameter<&P::extinction>("extinction", "1/m", 0.0, 1000.0,
                              "Light that a particle takes away on a metre through it, at its first radius."),
    parameter<&P::dilution>("dilution", "", 0.0, 1.0,
                            "Whether a particle thins as it grows: 1 keeps its mass, 0 its extinction."),
    parameter<&P::fade_in>("fade_in", "of the lifetime", 0.0, 1.0, "In which a particle becomes dense."),
    parameter<&P::fade_out>("fade_out", "of the lifetime", 0.0, 1.0, "In which it dissolves at the end."),
    parameter<&P::profile>(
        "profile", profiles,
        "How a particle's depth is spread over its disc: as a sphere's, in wisps of noise, or as the "
        "image 'profile' says."),
    parameter<&P::profile_strength>("profile_strength", "", 0.0, 1.0, "How far that goes from a sphere's."),
    parameter<&P::profile_scale>("profile_scale", "", 1.0, 6.0, "Wisps of noise across a radius."),
    parameter<&P::albedo_r>("albedo_r", "", 0.0, 1.0, "Share of red light that is scattered, not absorbed."),
    parameter<&P::albedo_g>("albedo_g", "", 0.0, 1.0, "Share of green light that is scattered, not absorbed."),
    parameter<&P::albedo_b>("albedo_b", "", 0.0, 1.0, "Share of blue light that is scattered, not absorbed."),
    parameter<&P::emission>(
        "emission", "", 0.0, 10000.0,
        "Radiance of the glow at birth, where opaque: red when weak, yellow and white when strong."),
    parameter<&P::emission_time>("emission_time", "s", 0.01, 100.0, "In which the glow falls to a third (1/e).",
                                 parameter_logarithmic),
    // Light.
    parameter<&P::phase>("phase", "", -0.95, 0.95,
                         "Henyey and Greenstein's g: above 0 scatters light onwards, below 0 back, 0 evenly."),
    parameter<&P::shadow_colour_r>("shadow_colour_r", "", 0.0, 4.0, "Extinction of red light on its way in."),
    parameter<&P::shadow_colour_g>("shadow_colour_g", "", 0.0, 4.0, "Extinction of green light on its way in."),
    parameter<&P::shadow_colour_b>("shadow_colour_b", "", 0.0, 4.0, "Extinction of blue light on its way in."),
    parameter<&P::light_azimuth>("light_azimuth", "°", -180.0, 180.0,
                                 "Where light comes from when the frame has none, from +z towards +x."),
    parameter<&P::light_elevation>("light_elevation", "°", -90.0, 90.0,
                                   "Where light comes from when the frame has none, above the horizon."),
    parameter<&P::light_strength>("light_strength", "", 0.0, 1000.0, "Its irradiance."),
    parameter<&P::ambient>("ambient", "", 0.0, 100.0, "Radiance from all sides, which nothing shadows."),
    // Drawing.
    parameter<&P::mode>("mode", modes,
                        "How light finds its way: layers of optical depth along the light, or half-angle slices."),
    parameter<&P::slices>("slices", "", 2, 256, "Slices of half-angle."),
    parameter<&P::layers>("layers", "", 4, 128, "Layers of light-volume."),
    parameter<&P::shadow_resolution>("shadow_resolution", "px", 64, 1024, "Side of the shadow buffer or volume."),
    parameter<&P::scattering_blur>("scattering_blur", "m²/m", 0.0, 10.0,
                                   "Variance by which light widens on a metre through the cloud."),
    parameter<&P::scattering_octaves>("scattering_octaves", "", 1, 4,
                                      "Orders of scattering, each half as strong and shadowed half as much."),
    parameter<&P::resolution>("resolution", resolutions,
                              "Of the image of the particles; the scene's edges stay sharp."),
    parameter<&P::simplification>("simplification", "", 0.0, 1.0,
                                  "At half and quarter resolution: how far small, thin particles may be drawn by some "
                                  "of their number, larger and denser instead; 0 draws all."),
    parameter<&P::sort_bits>("sort_bits", sort_bits, "Of the depth that particles are sorted by.", parameter_advanced),
    parameter<&P::soft_distance>("soft_distance", "m", 0.0, 10.0,
                                 "Before a surface in which particles fade, so that they do not cut it."),
    parameter<&P::near_fade>("near_fade", "m", 0.0, 10.0, "Before the camera in which particles fade."),
    parameter<&P::scene_shadow>("scene_shadow", "", 0.0, 1.0, "Strength of the particles' shadow on the scene."),
    parameter<&P::pairs_per_particle>("pairs_per_particle", "", 1, 256,
                                      "Room for pairs of particle and screen tile, a particle on the mean; what does "
                                      "not fit is left out and reported.",
                                      parameter_advanced),
    parameter<&P::debug_view>("debug_view", views, "Shows the inside of the effect.", parameter_debug),
};

constexpr PresetOverride half_angle[] = {{"mode", "half-angle"},
                                         {"slices", "64"},
                                         {"shadow_resolution", "256"},
                                         {"resolution", "half"},
                                         {"simplification", "0"}};
constexpr PresetOverride smoke[] = {{"extinction", "1.6"}, {"albedo_r", "0.55"},       {"albedo_g", "0.55"},
                                    {"albedo_b", "0.57"},  {"radius_end", "0.22"},     {"curl_strength", "1"},
                                    {"curl_octaves", "3"}, {"scattering_octaves", "2"}};
constexpr PresetOverride steam[] = {{"extinction", "1.2"}, {"albedo_r", "0.98"}, {"albedo_g", "0.98"},
                                    {"albedo_b", "0.99"},  {"gravity", "-1"},    {"lifetime", "3"},
                                    {"speed", "3"},        {"phase", "0.5"},     {"scattering_octaves", "3"}};
// All of a burst cools at the same time: what goes on burning in its middle shines through the gaps of its smoke.
constexpr PresetOverride explosion[] = {
    {"emitter", "sphere"},     {"count", "40960"},    {"burst", "9000"},     {"pairs_per_particle", "64"},
    {"rate", "14000"},         {"lifetime", "2"},     {"warm_up", "0"},      {"speed", "4.5"},
    {"spread", "180"},         {"drag", "4"},         {"gravity", "-1.5"},   {"curl_strength", "5"},
    {"curl_scale", "1"},       {"curl_octaves", "3"}, {"extinction", "2.5"}, {"dilution", "0.7"},
    {"radius_start", "0.08"},  {"radius_end", "0.4"}, {"albedo_r", "0.35"},  {"albedo_g", "0.33"},
    {"albedo_b", "0.32"},      {"ambient", "0.08"},   {"emission", "10"},    {"scattering_octaves", "2"},
    {"emission_time", "0.13"}, {"profile", "noise"}};
constexpr PresetOverride low[] = {
    {"count", "16384"},           {"rate", "2500"},    {"extinction", "4"},       {"layers", "12"},
    {"shadow_resolution", "128"}, {"sort_bits", "16"}, {"resolution", "quarter"}, {"curl_octaves", "1"}};
constexpr PresetOverride medium[] = {{"layers", "16"}, {"resolution", "half"}, {"sort_bits", "16"}};
constexpr PresetOverride high[] = {{"count", "262144"}, {"rate", "40000"}, {"extinction", "0.25"}};
constexpr PresetOverride ultra[] = {{"count", "1048576"},  {"rate", "160000"},           {"extinction", "0.0625"},
                                    {"radius_end", "0.2"}, {"shadow_resolution", "512"}, {"layers", "64"},
                                    {"curl_octaves", "3"}, {"sort_bits", "32"}};

constexpr Preset presets[] = {
    {"half-angle", "The document's method: 64 half-angle slices, a shadow buffer of 256², half resolution.",
     half_angle},
    {"smoke", "Grey smoke that rises and curls.", smoke},
    {"steam", "White steam under pressure that thins quickly.", steam},
    {"explosion", "A blast that billows and turns to dark smoke, with fire at its heart.", explosion},
    {"low", "Least time.", low},
    {"medium", "Half resolution and fewer layers.", medium},
    {"high", "A quarter of a million particles.", high},
    {"ultra", "A million particles, fine layers.", ultra},
};

template <Image ParticleVolumeImages::*member>
Image& image(void* images) {
    return static_cast<ParticleVolumeImages*>(images)->*member;
}
template <Buffer ParticleVolumeImages::*member>
Buffer& buffer(void* images) {
    return static_cast<ParticleVolumeImages*>(images)->*member;
}

using I = ParticleVolumeImages;
// In the order of ParticleImage.
constexpr ImageRole roles[] = {
    {"colour", "linear colour, alpha premultiplied", ImageUse::input, 3, false, image<&I::colour>},
    {"depth", "linear view depth or device depth, as Frame::depth_kind says", ImageUse::input, 1, false,
     image<&I::depth>},
    {"shadow_map", "depth of the scene seen from light 0, as its world_to_shadow says; larger is farther",
     ImageUse::optional_input, 1, false, image<&I::shadow_map>},
    {"direct", "the part of the colour that light 0 gives: only it is shadowed", ImageUse::optional_input, 3, false,
     image<&I::direct>},
    {"velocity", "pixels per frame, current minus previous, +x right, +y down: of the scene behind the particles",
     ImageUse::optional_input, 2, true, image<&I::velocity>},
    {"profile", "how optical depth is spread over a particle's disc, which touches the image's sides",
     ImageUse::optional_input, 1, false, image<&I::profile>},
    {"output", "the colour with the particles and their shadow", ImageUse::output, 3, false, image<&I::output>},
    {"velocity_output", "velocity of scene and particles, each by its share of what is seen", ImageUse::optional_output,
     2, true, image<&I::velocity_output>},
    {"transmittance", "share of the scene's light that comes through the particles", ImageUse::optional_output, 1,
     false, image<&I::transmittance>},
};
// In the order of ParticleBuffer.
constexpr BufferRole buffer_roles[] = {
    {"sprites", "the host's own particles (ParticleSprite) instead of simulated ones", ImageUse::optional_input,
     sizeof(ParticleSprite), uint64_t{most_particles} * sizeof(ParticleSprite), buffer<&I::sprites>},
    {"statistics", "what was drawn (one ParticleStatistics)", ImageUse::optional_output, sizeof(ParticleStatistics),
     sizeof(ParticleStatistics), buffer<&I::statistics>,
     [](const void* contents, const void* parameters) {
         return particle_shortfalls(*static_cast<const ParticleStatistics*>(contents),
                                    *static_cast<const ParticleVolumeParameters*>(parameters));
     }},
};

constexpr ParameterTable particles_table = parameter_table<P>("particles", rows, presets);

constexpr EffectInfo particles_effect = {
    "particles",
    "Smoke, steam and explosions that shadow themselves and the scene.",
    "Green, Volumetric Particle Shadowing, in DirectX 10/11 Visual Effects",
    &particles_table,
    roles,
    sizeof(ParticleVolumeImages),
    true,
    [](const Frame& frame, const void* parameters, const void* images) {
        return plan_particles(frame, *static_cast<const ParticleVolumeParameters*>(parameters),
                              *static_cast<const ParticleVolumeImages*>(images));
    },
    [](const Frame&, const void* parameters, const void* images) {
        return check_particles(*static_cast<const ParticleVolumeParameters*>(parameters),
                               *static_cast<const ParticleVolumeImages*>(images));
    },
    buffer_roles,
};

} // namespace

const ParameterTable& ParticleVolumeParameters::table() {
    return particles_table;
}
const EffectInfo& ParticleVolumeImages::effect() {
    return particles_effect;
}

} // namespace sfumato
