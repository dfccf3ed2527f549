// `times`: what each preset costs on each scene at each size, whole and per pass, beside what the device could do.
#include "apps/bench/commands.h"
#include "apps/bench/traffic.h"

#include <algorithm>

#include <fmt/format.h>

namespace sfumato::bench {
namespace {

constexpr double mebibyte = 1024.0 * 1024.0;

struct Row {
    const Variant* variant;
    std::string source;
    Extent extent;
    ChainTime chain;
    std::vector<PassStatistics> passes;
    std::vector<TileClassShare> classes;
    PlanTraffic traffic;
};

// Runs the effect with its view of tile classes, if it has one.
Result<std::vector<TileClassShare>> class_shares(Rig& rig, const Variant& variant, const InputSet& input) {
    const Adapter& adapter = adapter_of(*variant.effect);
    std::vector<TileClassShare> none;
    if (adapter.classes == nullptr)
        return none;
    ParameterSet parameters = variant.parameters;
    const ParameterTable& table = parameters.table();
    if (auto set = set_parameter(table, parameters.data(), adapter.class_parameter, adapter.class_value); !set)
        return set.error();
    auto context = rig.create_context(2, false);
    if (!context)
        return context.error();
    const SequenceFrame frame{input.frame, &input.images};
    if (auto run = run_sequence(rig, **context, *variant.effect, parameters.data(), {&frame, 1}); !run)
        return run.error();
    const auto view = rig.device().readback(input.images.output());
    if (!view)
        return view.error();
    return adapter.classes(*view);
}

Result<Row> measure(Rig& rig, const Options& options, const Variant& variant, const Source& source, Extent extent,
                    std::span<const InputSet> inputs, double warm_up) {
    Row row{&variant, source.name(), extent, {}, {}, {}, {}};
    const void* parameters = variant.parameters.data();
    const TimingOptions timing = timing_options(options, rig, warm_up);
    auto plan = plan_effect(*variant.effect, inputs.front().frame, parameters, inputs.front().images.data());
    if (!plan)
        return plan.error();
    row.traffic = traffic_of(*plan);
    auto chain = time_chain(rig, *variant.effect, parameters, inputs, timing);
    if (!chain)
        return chain.error();
    row.chain = *chain;
    if (!options.passes)
        return row;
    auto passes = time_passes(rig, *variant.effect, parameters, inputs, {timing.frames, 0.02, timing.batch});
    if (!passes)
        return passes.error();
    row.passes = std::move(*passes);
    auto classes = class_shares(rig, variant, inputs.front());
    if (!classes)
        return classes.error();
    row.classes = std::move(*classes);
    return row;
}

std::string class_text(const Row& row) {
    std::string text;
    for (const TileClassShare& tile_class : row.classes)
        text += fmt::format("{}{:.0f}", text.empty() ? "" : "/", 100.0 * tile_class.share);
    return text.empty() ? "-" : text;
}

double milliseconds(uint64_t bytes, double bandwidth) {
    return bandwidth > 0.0 ? static_cast<double>(bytes) / bandwidth * 1e3 : 0.0;
}

std::string chain_table(const std::vector<Row>& rows, const Machine& machine) {
    Table table({"effect", "preset", "scene", "size", "median ms", "min ms", "p95 ms", "moves MB", "limit ms",
                 "x limit", "held MB", "tiles %"},
                4);
    for (const Row& row : rows) {
        const double limit = milliseconds(row.traffic.bytes, machine.bandwidth());
        table.add({row.variant->effect->name, row.variant->label, row.source, extent_text(row.extent),
                   fixed(row.chain.chain.median, 4), fixed(row.chain.chain.minimum, 4), fixed(row.chain.chain.p95, 4),
                   fixed(static_cast<double>(row.traffic.bytes) * 1e-6, 1), fixed(limit, 4),
                   limit > 0.0 ? fixed(row.chain.chain.median / limit, 1) : "-",
                   fixed(static_cast<double>(row.chain.memory.transients + row.chain.memory.histories) / mebibyte, 1),
                   class_text(row)});
    }
    std::string text = table.text() + "moves: every image that a pass touches, once; limit: that at the copy's speed; "
                                      "held: transients and histories.\n";
    const auto with_classes = std::ranges::find_if(rows, [](const Row& row) { return !row.classes.empty(); });
    if (with_classes != rows.end()) {
        std::string names;
        for (const TileClassShare& tile_class : with_classes->classes)
            names += (names.empty() ? "" : "/") + tile_class.name;
        text += "tiles: " + names + ", share of the pixels.\n";
    }
    return text;
}

// One row a pass, over all scenes of the same preset and size.
std::string pass_table(const std::vector<Row>& rows, const Machine& machine) {
    Table table({"effect", "preset", "size", "pass", "mean ms", "least", "most", "moves MB", "limit ms", "GB/s"}, 4);
    std::vector<bool> done(rows.size(), false);
    for (size_t i = 0; i < rows.size(); ++i) {
        if (done[i])
            continue;
        for (size_t pass = 0; pass < rows[i].passes.size(); ++pass) {
            double sum = 0.0, least = 1e30, most = 0.0, count = 0.0;
            for (size_t j = i; j < rows.size(); ++j) {
                if (rows[j].variant != rows[i].variant || !(rows[j].extent == rows[i].extent) ||
                    rows[j].passes.size() <= pass)
                    continue;
                done[j] = true;
                const double median = rows[j].passes[pass].time.median;
                sum += median;
                least = std::min(least, median);
                most = std::max(most, median);
                count += 1.0;
            }
            const PassTraffic& traffic = rows[i].traffic.passes[pass];
            const double mean = sum / count;
            const double rate = mean > 0.0 ? static_cast<double>(traffic.bytes) / (mean * 1e-3) * 1e-9 : 0.0;
            const std::string bound = traffic.is_upper_bound ? "<=" : "";
            table.add({rows[i].variant->effect->name, rows[i].variant->label, extent_text(rows[i].extent),
                       rows[i].passes[pass].pass, fixed(mean, 4), fixed(least, 4), fixed(most, 4),
                       bound + fixed(static_cast<double>(traffic.bytes) * 1e-6, 1),
                       bound + fixed(milliseconds(traffic.bytes, machine.bandwidth()), 4),
                       traffic.is_upper_bound ? "-" : fixed(rate, rate < 10.0 ? 2 : 0)});
        }
    }
    return "Passes: medians of each scene, mean, least and most over the scenes. <= marks indirect dispatches, which "
           "share their images; passes without a barrier between them overlap.\n" +
           table.text();
}

Json row_json(const Row& row, const Machine& machine) {
    Json passes = Json::array();
    for (size_t i = 0; i < row.passes.size(); ++i) {
        const PassTraffic& traffic = row.traffic.passes[i];
        passes.push_back({{"pass", row.passes[i].pass},
                          {"time", statistics_json(row.passes[i].time)},
                          {"bytes", traffic.bytes},
                          {"bytes_are_upper_bound", traffic.is_upper_bound},
                          {"group", traffic.group}});
    }
    Json classes = Json::object();
    for (const TileClassShare& tile_class : row.classes)
        classes[tile_class.name] = tile_class.share;
    return {{"effect", row.variant->effect->name},
            {"preset", row.variant->label},
            {"scene", row.source},
            {"width", row.extent.width},
            {"height", row.extent.height},
            {"time", statistics_json(row.chain.chain)},
            {"transient_bytes", row.chain.memory.transients},
            {"history_bytes", row.chain.memory.histories},
            {"moved_bytes", row.traffic.bytes},
            {"least_bytes", row.traffic.minimum},
            {"limit_ms", milliseconds(row.traffic.bytes, machine.bandwidth())},
            {"tile_classes", classes},
            {"passes", passes}};
}

// All variants of one source at one size.
Result<void> measure_source(Rig& rig, const Options& options, const Variants& variants, const Source& source,
                            Extent extent, const Output& output, std::vector<Row>& rows) {
    TimedInputs inputs;
    const EffectInfo* loaded = nullptr;
    for (const Variant& variant : variants) {
        if (!source.suits(variant.effect->name))
            continue;
        if (loaded != variant.effect) {
            inputs = {}; // the old ones go first: at large sizes they fill the memory
            auto fresh = load_timed_inputs(rig, options, *variant.effect, source, extent);
            if (!fresh)
                return fresh.error();
            inputs = std::move(*fresh);
            loaded = variant.effect;
        }
        output.progress(
            fmt::format("{} {} {} {}", variant.effect->name, variant.label, source.name(), extent_text(extent)));
        // Once clocks have settled, a shorter warm-up keeps them there.
        const double warm_up = rows.empty() ? options.warm_up : std::min(options.warm_up, 0.05);
        auto row = measure(rig, options, variant, source, extent, inputs.sets, warm_up);
        if (!row)
            return row.error();
        rows.push_back(std::move(*row));
    }
    return {};
}

} // namespace

std::vector<Extent> times_sizes(const Options& options, const Rig& rig, bool only_one) {
    std::vector<Extent> sizes = options.sizes;
    if (sizes.empty() && rig.is_cpu())
        sizes = {{256, 144}};
    if (sizes.empty())
        sizes =
            only_one ? std::vector<Extent>{{1920, 1080}} : std::vector<Extent>{{1280, 720}, {1920, 1080}, {3840, 2160}};
    if (only_one)
        sizes.resize(1);
    return sizes;
}

TimingOptions timing_options(const Options& options, const Rig& rig, double warm_up) {
    const int frames = rig.is_cpu() ? 10 : 100;
    const int batch = rig.is_cpu() ? 1 : 8; // a software device gains nothing from batches
    return {options.frames > 0 ? options.frames : frames, warm_up,
            static_cast<uint32_t>(options.batch > 0 ? options.batch : batch)};
}

Result<TimedInputs> load_timed_inputs(Rig& rig, const Options& options, const EffectInfo& effect, const Source& source,
                                      Extent extent) {
    TimedInputs timed;
    const std::vector<int> offsets = options.rotate ? std::vector<int>{-1, 0, 1} : std::vector<int>{0};
    for (const int offset : offsets) {
        LoadRequest request{extent, offset, wanted_planes(effect, options.opted_in), {}};
        request.is_compact = true;
        request.options.samples = options.samples;
        auto inputs = source.load(rig, request);
        if (!inputs)
            return inputs.error();
        timed.inputs.push_back(std::make_unique<Inputs>(std::move(*inputs)));
        auto images = BoundImages::create(rig, effect, *timed.inputs.back(), options.opted_in);
        if (!images)
            return images.error();
        timed.sets.push_back({timed.inputs.back()->frame, std::move(*images)});
    }
    rig.trim(); // at large sizes what rendering holds is better free
    return timed;
}

Result<void> measure_times(Rig& rig, const Options& options, const Variants& variants, const Sources& sources,
                           const Output& output) {
    const auto machine = measure_machine(rig);
    if (!machine)
        return machine.error();
    output.print(header_text("times", rig) + machine_text(*machine) + "\n");
    std::vector<Row> rows;
    for (const Extent extent : times_sizes(options, rig, false))
        for (const auto& source : sources)
            if (auto done = measure_source(rig, options, variants, *source, extent, output, rows); !done)
                return done;
    output.print(chain_table(rows, *machine) + "\n");
    if (options.passes)
        output.print(pass_table(rows, *machine));
    Json json = {{"program", "sfumato-bench"},
                 {"command", "times"},
                 {"device", device_json(rig)},
                 {"machine", machine_json(*machine)},
                 {"frames", timing_options(options, rig, 0.0).frames},
                 {"rotate", options.rotate},
                 {"rows", Json::array()}};
    for (const Row& row : rows)
        json["rows"].push_back(row_json(row, *machine));
    return output.write(json);
}

} // namespace sfumato::bench
