// Setting up and running the viewer.
#include "apps/viewer/viewer.h"

#include "apps/cli/exit_code.h"
#include "apps/viewer/session.h"
#include "apps/viewer/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <backends/imgui_impl_glfw.h>
#include <chrono>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>

namespace sfumato::viewer {

namespace {

using cli::as_device;

// Longest sleep of a viewer where nothing happens; events wake it.
constexpr double idle_seconds = 0.25;

Result<void> choose_truth(Model& model, const std::string& name) {
    if (name.empty())
        return {};
    const TruthKind wanted = name == "motion-blur" ? TruthKind::motion_blur : TruthKind::occlusion;
    if (name != "motion-blur" && name != "ambient-occlusion")
        return cli::usage_error(fmt::format("--truth {}: there are motion-blur and ambient-occlusion", name));
    model.truth.kind = wanted;
    if (!model.truth_effect())
        return cli::usage_error(fmt::format("--truth {}: no effect that is on approximates it; see --effects", name));
    return {};
}

Result<void> choose_picture(const Model& model, const char* option, const std::string& id) {
    std::vector<std::string> names;
    for (const PictureChoice& choice : model.pictures())
        names.push_back(choice.id);
    if (std::ranges::find(names, id) != names.end())
        return {};
    const std::string hint = cli::did_you_mean(id, names);
    return cli::usage_error(fmt::format("{} {}: there is no such picture{}", option, id,
                                        hint.empty() ? fmt::format("; there are {}", fmt::join(names, ", ")) : hint));
}

// What depends on the scene, which is known by now.
Result<void> apply_options(Model& model, const ViewerOptions& options) {
    if (options.frame) {
        if (*options.frame < model.first_frame() || *options.frame > model.last_frame())
            return cli::usage_error(fmt::format("--frame {}: {} has {} to {}", *options.frame, options.scene,
                                                model.first_frame(), model.last_frame()));
        model.scrub(*options.frame);
    }
    if (!options.viewpoint.empty()) {
        if (auto set = model.set_viewpoint(options.viewpoint); !set)
            return set;
    }
    if (auto chosen = choose_truth(model, options.truth); !chosen)
        return chosen;
    if (auto known = choose_picture(model, "--left", options.left); !known)
        return known;
    if (auto known = choose_picture(model, "--right", options.right); !known)
        return known;
    model.left = options.left;
    model.right = options.right;
    model.split = options.split >= 0.0;
    if (model.split)
        model.divider = options.split;
    model.scale = options.scale;
    model.samples = options.samples;
    model.preroll = options.preroll;
    if (!options.output.empty())
        model.picture_path = options.output;
    if (options.play)
        model.play(true);
    return {};
}

Result<void> check_validation(const apps::Device& device) {
    const auto messages = device.validation_messages();
    if (messages.empty())
        return {};
    return Error{ErrorCode::internal,
                 fmt::format("{} messages of the validation layer, the first: {}", messages.size(), messages.front())};
}

apps::DeviceOptions device_options(const ViewerOptions& options) {
    apps::DeviceOptions result;
    result.device = options.device;
    result.validation = options.validate;
    result.graphics = !options.headless || options.panels;
    return result;
}

Result<void> run_headless(const ViewerOptions& options, Model model, const SceneOpener& open,
                          const std::function<void(const std::string&)>& note) {
    auto device = apps::Device::create(device_options(options));
    if (!device)
        return as_device(device.error());
    {
        auto session = Session::create(**device, std::move(model), options.scene, open,
                                       {options.panels, 1.0f, options.widget_log});
        if (!session)
            return session.error();
        if (auto applied = apply_options((*session)->model(), options); !applied)
            return applied;
        ImGuiIO& io = ImGui::GetIO();
        io.DisplaySize = {static_cast<float>(options.size.width), static_cast<float>(options.size.height)};
        const double period = 1.0 / (*session)->model().info.frames_per_second;
        for (int turn = 0; turn < options.turns; ++turn) {
            io.DeltaTime = static_cast<float>(period);
            if (auto done = (*session)->turn(turn == 0 ? 0.0 : period, options.size); !done)
                return done;
            if ((*session)->has_failed())
                return Error{ErrorCode::invalid_argument, (*session)->message()};
        }
        if (auto written = write_canvas(**device, (*session)->canvas(), options.output); !written)
            return written;
        note("wrote " + options.output);
        if (!(*session)->truth_text().empty())
            note((*session)->truth_text());
        for (const std::string& line : (*session)->shortfalls())
            note(line);
    }
    return check_validation(**device);
}

// ImGui's connection to the window.
class WindowInput {
  public:
    WindowInput(GLFWwindow* window, Session& session) {
        glfwSetWindowUserPointer(window, &session);
        // ImGui hands on what it receives to those who came before.
        glfwSetKeyCallback(window, [](GLFWwindow* from, int key, int, int action, int modifiers) {
            if (action != GLFW_RELEASE)
                static_cast<Session*>(glfwGetWindowUserPointer(from))->press(key, (modifiers & GLFW_MOD_CONTROL) != 0);
        });
        ImGui_ImplGlfw_InitForVulkan(window, true);
    }
    ~WindowInput() { ImGui_ImplGlfw_Shutdown(); }
    WindowInput(const WindowInput&) = delete;
    WindowInput& operator=(const WindowInput&) = delete;
};

Result<void> run_loop(Window& window, Session& session) {
    const WindowInput input(window.handle(), session);
    auto before = std::chrono::steady_clock::now();
    // After something has happened the panels need a few turns to show all of it.
    int awake = 3;
    while (!window.should_close() && !session.wants_to_quit()) {
        const bool minimised = !window.framebuffer();
        const bool waits = minimised || (!session.is_busy() && awake <= 0);
        const auto slept = std::chrono::steady_clock::now();
        window.poll(waits ? idle_seconds : 0.0);
        const auto now = std::chrono::steady_clock::now();
        const double seconds = std::chrono::duration<double>(now - before).count();
        before = now;
        const bool woken = waits && std::chrono::duration<double>(now - slept).count() < 0.95 * idle_seconds;
        awake = woken ? 3 : awake - 1;
        const Extent framebuffer = window.framebuffer();
        if (!framebuffer)
            continue;
        ImGui_ImplGlfw_NewFrame();
        if (auto done = session.turn(seconds, framebuffer); !done)
            return done;
        if (auto shown = window.present(session.canvas().image()); !shown)
            return as_device(shown.error());
    }
    return {};
}

Result<void> run_window(const ViewerOptions& options, Model model, const SceneOpener& open,
                        const std::function<void(const std::string&)>& note) {
    auto window = Window::open(options.size, fmt::format("{} - Sfumato", options.scene));
    if (!window)
        return Error{ErrorCode::vulkan, window.error().message + "; --headless -o picture.png needs none"};
    apps::DeviceOptions wanted = device_options(options);
    wanted.instance_extensions = Window::instance_extensions();
    wanted.device_extensions = {VK_KHR_SWAPCHAIN_EXTENSION_NAME};
    auto device = apps::Device::create(wanted);
    if (!device)
        return as_device(device.error());
    note("device: " + (*device)->name());
    Result<void> result;
    {
        auto session = Session::create(**device, std::move(model), options.scene, open,
                                       {true, (*window)->content_scale(), options.widget_log});
        if (!session)
            result = session.error();
        else if (auto applied = apply_options((*session)->model(), options); !applied)
            result = applied;
        else if (auto attached = (*window)->attach(**device); !attached)
            result = as_device(attached.error());
        else
            result = run_loop(**window, **session);
    }
    (*window)->detach(); // the device goes before the window
    return result ? check_validation(**device) : result;
}

} // namespace

Result<void> run_viewer(const ViewerOptions& options, const std::function<void(const std::string&)>& note) {
    auto model = Model::create(options.chain);
    if (!model)
        return model.error();
    cli::SceneOptions scene;
    scene.scene = options.scene;
    scene.animation = options.animation;
    scene.no_ground = options.no_ground;
    model->scene_options = scene;
    const auto chosen = viewer::choose_scene(scene);
    if (!chosen)
        return chosen.error();
    model->adapt(options.chain, chosen->fit);
    if (!options.save_config.empty())
        if (auto saved = model->save(options.save_config); !saved)
            return saved;
    return options.headless ? run_headless(options, std::move(*model), chosen->open, note)
                            : run_window(options, std::move(*model), chosen->open, note);
}

} // namespace sfumato::viewer
