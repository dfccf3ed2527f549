// Time, camera and effects of the viewer.
#include "apps/viewer/model.h"

#include "apps/cli/exit_code.h"
#include "apps/cli/viewpoint.h"

#include <algorithm>
#include <cmath>

namespace sfumato::viewer {

namespace {

const EffectSlot* find_slot(const std::vector<EffectSlot>& slots, const EffectInfo* effect) {
    const auto found = std::ranges::find_if(slots, [&](const auto& slot) { return slot.link.effect == effect; });
    return found == slots.end() ? nullptr : &*found;
}

std::string all_effects() {
    std::string names;
    for (const std::string& name : cli::effect_names())
        names += (names.empty() ? "" : ",") + name;
    return names;
}

} // namespace

Result<Model> Model::create(const cli::ChainOptions& options) {
    Model model;
    model.effects_named_ = !options.effects.empty();
    if (!model.effects_named_ && (!options.preset.empty() || !options.settings.empty()))
        return cli::usage_error("--preset and --set are for effects; name them with --effects");
    cli::ChainOptions named = options;
    if (!model.effects_named_)
        named.effects = all_effects();
    auto chain = cli::make_chain(named);
    if (!chain)
        return chain.error();
    for (cli::ChainLink& link : *chain)
        model.effects_.push_back({std::move(link), model.effects_named_});
    for (const EffectInfo* effect : sfumato::effects())
        if (!find_slot(model.effects_, effect))
            model.effects_.push_back({{effect, "", ParameterSet(*effect->parameters)}, false});
    return model;
}

void Model::adapt(const cli::ChainOptions& given, const cli::SceneFit& fit) {
    fit_ = fit;
    if (given.config.empty())
        for (EffectSlot& slot : effects_)
            cli::adapt_link(slot.link, fit);
}

void Model::set_scene(const std::string& name, const scene::SceneSource& source) {
    scene_name = name;
    info = source.info();
    bounds = source.bounds();
    scene_view_angle_ = source.view(info.key_frame).view_angle;
    frame_ = std::clamp(info.key_frame, first_frame(), last_frame());
    camera_mode_ = CameraMode::scene;
    cut_ = true;
    for (EffectSlot& slot : effects_)
        if (!effects_named_)
            slot.enabled = scene::is_for(info, slot.link.effect->name);
}

// --- time

void Model::play(bool on) {
    playing_ = on;
    clock_ = 0.0;
}

void Model::step(int frames) {
    play(false);
    const int count = last_frame() - first_frame() + 1;
    frame_ = first_frame() + ((frame_ - first_frame() + frames) % count + count) % count;
    cut_ = true;
}

void Model::scrub(int new_frame) {
    play(false);
    cut_ = cut_ || new_frame != frame_;
    frame_ = std::clamp(new_frame, first_frame(), last_frame());
}

bool Model::advance(double seconds) {
    if (!playing_)
        return false;
    const double period = 1.0 / info.frames_per_second;
    clock_ += seconds;
    if (clock_ < period)
        return false;
    clock_ = std::min(clock_ - period, period);
    cut_ = cut_ || frame_ == last_frame();
    frame_ = frame_ == last_frame() ? first_frame() : frame_ + 1;
    return true;
}

bool Model::take_cut() {
    return std::exchange(cut_, false);
}

// --- camera

void Model::set_camera_mode(CameraMode mode, const scene::View& seen) {
    if (mode != CameraMode::scene && camera_mode_ == CameraMode::scene)
        camera_ = CameraRig(seen, bounds);
    if (mode == CameraMode::scene)
        told_viewpoint_.clear();
    cut_ = cut_ || (mode == CameraMode::scene) != (camera_mode_ == CameraMode::scene);
    camera_mode_ = mode;
}

CameraRig& Model::move_camera(const scene::View& seen) {
    if (camera_mode_ == CameraMode::scene)
        set_camera_mode(CameraMode::orbit, seen);
    told_viewpoint_.clear();
    return camera_;
}

Result<void> Model::set_viewpoint(const std::string& text) {
    const auto view = cli::parse_viewpoint(text, scene_view_angle_);
    if (!view)
        return view.error();
    camera_ = CameraRig(*view, bounds);
    camera_mode_ = CameraMode::orbit;
    told_viewpoint_ = text;
    cut_ = true;
    return {};
}

std::string Model::viewpoint_text() const {
    if (camera_mode_ == CameraMode::scene)
        return "";
    return told_viewpoint_.empty() ? cli::viewpoint_text(camera_.view()) : told_viewpoint_;
}

std::optional<scene::View> Model::viewpoint() const {
    const std::string text = viewpoint_text();
    if (text.empty())
        return std::nullopt;
    const auto told = cli::parse_viewpoint(text, camera_.view_angle());
    return told ? *told : camera_.view();
}

// --- effects

void Model::move_effect(size_t place, int by) {
    if (place >= effects_.size())
        return;
    const auto last = static_cast<ptrdiff_t>(effects_.size()) - 1;
    const auto to = std::clamp<ptrdiff_t>(static_cast<ptrdiff_t>(place) + by, 0, last);
    const auto from = effects_.begin() + static_cast<ptrdiff_t>(place);
    const auto target = effects_.begin() + to;
    if (target < from)
        std::rotate(target, from, from + 1);
    else
        std::rotate(from, from + 1, target + 1);
}

void Model::set_value(EffectSlot& slot, const ParameterInfo& parameter, double value) {
    if (!std::isfinite(value))
        return;
    if (parameter.kind != ParameterKind::real)
        value = std::round(value);
    parameter.set(slot.link.parameters.data(), std::clamp(value, parameter.minimum, parameter.maximum));
}

Result<void> Model::choose_preset(EffectSlot& slot, const std::string& preset) {
    // What is only looked at is no part of a look.
    std::vector<std::pair<const ParameterInfo*, double>> views;
    for (const ParameterInfo& parameter : slot.link.effect->parameters->parameters)
        if (parameter.flags & parameter_debug)
            views.emplace_back(&parameter, parameter.get(slot.link.parameters.data()));
    if (auto applied = apply_preset(*slot.link.effect->parameters, slot.link.parameters.data(), preset); !applied)
        return applied;
    slot.link.preset = preset;
    slot.link.set_by_hand.clear(); // the preset has replaced it
    if (fit_)
        cli::adapt_link(slot.link, *fit_);
    for (const auto& [parameter, value] : views)
        parameter->set(slot.link.parameters.data(), value);
    return {};
}

double Model::preset_value(const EffectSlot& slot, const ParameterInfo& parameter) const {
    cli::ChainLink base{slot.link.effect, slot.link.preset, ParameterSet(*slot.link.effect->parameters)};
    // A preset that was applied once can be applied again.
    static_cast<void>(
        static_cast<bool>(apply_preset(*base.effect->parameters, base.parameters.data(), slot.link.preset)));
    if (fit_)
        cli::adapt_link(base, *fit_);
    return parameter.get(base.parameters.data());
}

void Model::reset_value(EffectSlot& slot, const ParameterInfo& parameter) {
    parameter.set(slot.link.parameters.data(), preset_value(slot, parameter));
}

bool Model::is_changed(const EffectSlot& slot, const ParameterInfo& parameter) const {
    return parameter.get(slot.link.parameters.data()) != preset_value(slot, parameter);
}

Result<void> Model::load(const std::string& path) {
    cli::EffectChain chain;
    for (const EffectSlot& slot : effects_)
        chain.push_back({slot.link.effect, "", ParameterSet(*slot.link.effect->parameters)});
    if (auto loaded = cli::load_config(chain, path); !loaded)
        return loaded;
    for (size_t i = 0; i < effects_.size(); ++i)
        effects_[i].link = std::move(chain[i]);
    return {};
}

Result<void> Model::save(const std::string& path) const {
    cli::EffectChain chain;
    for (const EffectSlot& slot : effects_)
        chain.push_back(slot.link);
    return cli::save_config(chain, path, false);
}

} // namespace sfumato::viewer
