// What happens in one turn.
#include "apps/viewer/session.h"

#include "apps/cli/exit_code.h"
#include "apps/cli/frame_writer.h"
#include "media/exr_file.h"
#include "media/png_file.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <imgui.h>

namespace sfumato::viewer {

namespace {

// So long the picture of a camera that was moved stays as it is before it is made anew as one that stands still.
constexpr double settling_seconds = 0.2;

// The scene, the effect or a file objects; the viewer can go on.
bool is_tolerable(const Error& error) {
    return error.code == ErrorCode::invalid_argument || error.code == ErrorCode::unsupported ||
           error.code == ErrorCode::input;
}

} // namespace

Session::Session(apps::Device& device, Model model, const SessionOptions& options)
    : device_(device), model_(std::move(model)), log_(options.widget_log), ui_(model_, log_) {
    imgui_ = ImGui::CreateContext();
    ImGui::SetCurrentContext(imgui_);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr; // leaves no files
    io.LogFilename = nullptr;
    ImGui::StyleColorsDark();
    ImGui::GetStyle().ScaleAllSizes(options.font_scale);
    ImGui::GetStyle().WindowBorderSize = 0.0f;
    ImFontConfig font;
    font.SizePixels = std::round(13.0f * options.font_scale);
    io.Fonts->AddFontDefault(&font);
}

Session::~Session() {
    static_cast<void>(static_cast<bool>(device_.wait_idle()));
    ui_renderer_.reset();
    ImGui::DestroyContext(imgui_);
}

Result<std::unique_ptr<Session>> Session::create(apps::Device& device, Model model, const std::string& scene_name,
                                                 const SceneOpener& open, const SessionOptions& options) {
    std::unique_ptr<Session> session(new Session(device, std::move(model), options));
    auto renderer = PictureRenderer::create(device, open);
    if (!renderer)
        return renderer.error();
    session->renderer_ = std::move(*renderer);
    auto composer = Composer::create(session->renderer_->context());
    if (!composer)
        return cli::as_device(composer.error());
    session->composer_ = std::move(*composer);
    if (options.draws_ui) {
        auto ui_renderer = UiRenderer::create(device);
        if (!ui_renderer)
            return cli::as_device(ui_renderer.error());
        session->ui_renderer_ = std::move(*ui_renderer);
    } else {
        session->model_.show_interface = false;
        unsigned char* pixels = nullptr;
        int width = 0, height = 0;
        ImGui::GetIO().Fonts->GetTexDataAsAlpha8(&pixels, &width, &height); // ImGui insists on an atlas
    }
    session->truth_ = std::make_unique<Truth>(*session->renderer_);
    session->model_.set_scene(scene_name, session->renderer_->source());
    session->status_.device = device.name();
    session->status_.timestamps = device.timestamps();
    session->status_.times = &session->times_;
    session->status_.seen = session->renderer_->source().view(session->model_.frame());
    return session;
}

Extent Session::picture_extent(Extent canvas) const {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const Rectangle area = ui_.picture_area(size.x, size.y);
    const auto pixels = [&](float length, float window, uint32_t framebuffer) {
        const double share = static_cast<double>(length) / std::max(static_cast<double>(window), 1.0);
        return static_cast<uint32_t>(std::max(std::round(share * framebuffer * model_.scale), 1.0));
    };
    return {pixels(area.width, size.x, canvas.width), pixels(area.height, size.y, canvas.height)};
}

void Session::report(const Result<void>& done, const std::string& message) {
    status_.message = done ? message : done.error().message;
    status_.is_error = !done;
}

// Shows an error that the viewer can go on after, and hands on every other.
Result<void> Session::tolerate(const Result<void>& done) {
    if (done || !is_tolerable(done.error()))
        return done;
    report(done, "");
    return {};
}

Result<void> Session::turn(double seconds, Extent canvas) {
    ++turns_;
    busy_ = false;
    ImGui::NewFrame();
    status_.picture = picture_extent(canvas);
    const UiActions actions = ui_.draw(status_);
    ImGui::Render();
    const bool moved = model_.advance(seconds);
    request_ = model_.request(picture_extent(canvas));
    status_.picture = request_.extent;
    if (auto rendered = render(seconds, moved, request_); !rendered)
        return rendered;
    status_.command = model_.command_line(request_.extent, model_.picture_path);
    if (auto performed = perform(actions); !performed)
        return performed;
    if (auto drawn = draw(canvas); !drawn)
        return drawn;
    log_widgets();
    return {};
}

Result<void> Session::render(double seconds, bool moved, const PictureRequest& request) {
    const std::string key = request.key();
    if (key == failed_)
        return {};
    const bool camera_moves = request.viewpoint && last_view_ && !same_view(*request.viewpoint, *last_view_);
    since_moved_ = camera_moves ? 0.0 : since_moved_ + seconds;
    const bool is_moving = model_.playing() || camera_moves;
    const bool is_first = pictures_ == 0;
    Result<void> done;
    bool rendered = true;
    if (!is_first && is_moving && (moved || camera_moves)) {
        done = renderer_->follow(request, last_view_, model_.take_cut());
        settled_.clear();
    } else if (is_first || (!is_moving && since_moved_ >= settling_seconds && (key != settled_ || model_.measure))) {
        static_cast<void>(model_.take_cut());
        done = renderer_->settle(request);
        settled_ = key;
    } else {
        rendered = false;
    }
    failed_ = done ? "" : key;
    if (auto tolerated = tolerate(done); !tolerated)
        return tolerated;
    if (rendered && done) {
        ++pictures_;
        times_.add(renderer_->times());
        status_.shortfalls.clear();
        for (const cli::EffectShortfall& one : renderer_->shortfalls())
            status_.shortfalls.push_back(cli::shortfall_text(one));
        last_view_ = request.viewpoint;
        status_.seen = renderer_->source().view(request.frame);
        if (status_.is_error)
            report({}, "");
    }
    busy_ = is_moving || since_moved_ < settling_seconds || model_.measure;
    return done && settled_ == key && !model_.measure ? gather_truth(request) : Result<void>{};
}

Result<void> Session::gather_truth(const PictureRequest& request) {
    const auto gathered = truth_->gather(model_, request);
    status_.truth_done = truth_->done();
    status_.truth_total = truth_->total();
    status_.truth_error = truth_->error();
    if (!gathered)
        return tolerate(gathered.error());
    busy_ = busy_ || *gathered;
    return {};
}

std::string Session::truth_text() const {
    if (!status_.truth_error)
        return "";
    return fmt::format("RMSE {:.6f}, PSNR {:.2f} dB against the truth, {} of {}", status_.truth_error->rmse,
                       status_.truth_error->psnr, status_.truth_done, status_.truth_total);
}

Result<void> Session::perform(const UiActions& actions) {
    quits_ = quits_ || actions.quit;
    if (actions.freeze) {
        if (auto frozen = renderer_->freeze(); !frozen)
            return frozen;
        model_.frozen = model_.split = true;
        model_.left = "frozen";
    }
    std::string exr = model_.picture_path;
    if (exr.ends_with(".png"))
        exr.replace(exr.size() - 3, 3, "exr");
    if (actions.save_png)
        report(save_png(model_.picture_path), "wrote " + model_.picture_path);
    if (actions.save_exr)
        report(save_exr(exr), "wrote " + exr);
    if (actions.save)
        report(model_.save(model_.config_path), "wrote " + model_.config_path);
    if (actions.load)
        report(model_.load(model_.config_path), "read " + model_.config_path);
    if (actions.copy) {
        ImGui::SetClipboardText(status_.command.c_str());
        report({}, "copied");
    }
    return {};
}

Composition Session::composition(Extent canvas) const {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const Rectangle area = ui_.picture_area(size.x, size.y);
    const float x = static_cast<float>(canvas.width) / std::max(size.x, 1.0f);
    const float y = static_cast<float>(canvas.height) / std::max(size.y, 1.0f);
    const Image truth = truth_->mean(model_, request_);
    Composition result;
    const auto side = [&](const std::string& id) {
        const PictureChoice choice = model_.picture(id);
        Side made{choice.id == "truth" ? truth : renderer_->picture(choice.id), choice.kind};
        // In place of colour there may be a plane.
        if (made.kind == PictureKind::colour && made.image.format == VK_FORMAT_R32_SFLOAT)
            made.kind = PictureKind::grey;
        const bool is_difference = made.kind == PictureKind::difference || made.kind == PictureKind::grey_difference;
        if (is_difference && !truth)
            made.kind = PictureKind::colour; // nothing yet: black
        return made;
    };
    result.left = side(model_.left);
    result.right = side(model_.right);
    result.compared = renderer_->picture(model_.compared_picture());
    result.truth = truth;
    result.area = {area.x * x, area.y * y, area.width * x, area.height * y};
    if (model_.split)
        result.divider = result.area.x + static_cast<float>(model_.divider) * result.area.width;
    result.exposure = model_.exposure;
    result.gain = model_.gain;
    result.near_depth = model_.bounds.radius;
    return result;
}

Result<void> Session::draw(Extent extent) {
    if (canvas_.extent() != extent) {
        if (ui_renderer_)
            ui_renderer_->forget_canvas();
        const VkImageUsageFlags usage = ui_renderer_ ? VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT : 0;
        auto made = device_.create_image(canvas_format, extent, usage);
        if (!made)
            return cli::as_device(made.error());
        canvas_ = std::move(*made);
    }
    auto commands = device_.begin();
    if (!commands)
        return cli::as_device(commands.error());
    if (auto recorded = composer_->record(*commands, composition(extent), canvas_.image()); !recorded)
        return cli::as_device(recorded.error());
    if (ui_renderer_)
        if (auto recorded = ui_renderer_->record(*commands, *ImGui::GetDrawData(), canvas_.image()); !recorded)
            return cli::as_device(recorded.error());
    if (auto done = device_.submit_and_wait(); !done)
        return cli::as_device(done.error());
    return {};
}

Result<void> Session::save_png(const std::string& path) {
    const Extent extent = status_.picture;
    auto picture = device_.create_image(canvas_format, extent);
    if (!picture)
        return cli::as_device(picture.error());
    Composition shown = composition(extent);
    shown.area = {0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height)};
    if (model_.split)
        shown.divider = static_cast<float>(model_.divider) * shown.area.width;
    auto commands = device_.begin();
    if (!commands)
        return cli::as_device(commands.error());
    if (auto recorded = composer_->record(*commands, shown, picture->image()); !recorded)
        return cli::as_device(recorded.error());
    if (auto done = device_.submit_and_wait(); !done)
        return cli::as_device(done.error());
    return write_canvas(device_, *picture, path);
}

Result<void> write_canvas(apps::Device& device, const apps::HostImage& canvas, const std::string& path) {
    const auto bytes = device.readback_bytes(canvas);
    if (!bytes)
        return cli::as_device(bytes.error());
    media::PngImage image;
    image.width = static_cast<int>(canvas.extent().width);
    image.height = static_cast<int>(canvas.extent().height);
    image.samples.reserve(bytes->size() / 4 * 3);
    for (size_t i = 0; i < bytes->size(); ++i)
        if (i % 4 != 3)
            image.samples.push_back(std::to_integer<uint16_t>((*bytes)[i]));
    return media::write_png(path, image);
}

Result<void> Session::save_exr(const std::string& path) {
    auto frame = renderer_->read_back();
    if (!frame)
        return frame.error();
    media::ExrImage image = cli::rendered_image(*frame, false);
    cli::add_provenance(image.parts.front(), renderer_->chain(), status_.command);
    image.parts.front().set_string_attribute("sfumato/scene", model_.scene_name);
    return media::write_exr(path, image);
}

void Session::log_widgets() {
    const auto number = [](auto value) { return static_cast<double>(value); };
    log_.write({{"turns", number(turns_)},
                {"pictures", number(pictures_)},
                {"busy", busy_ ? 1.0 : 0.0},
                {"frame", number(model_.frame())},
                {"playing", model_.playing() ? 1.0 : 0.0},
                {"truth_done", number(truth_->done())},
                {"picture_width", number(status_.picture.width)},
                {"picture_height", number(status_.picture.height)},
                {"divider", model_.divider}},
               status_.command);
}

} // namespace sfumato::viewer
