// sfumato-bench: what each effect costs on this machine, and how far it is from ground truth.
#include "apps/bench/commands.h"
#include "apps/bench/options.h"
#include "apps/bench/particles.h"

#include <algorithm>
#include <cstdio>
#include <exception>

namespace {

using namespace sfumato;

int exit_code(ErrorCode code) {
    switch (code) {
    case ErrorCode::invalid_argument:
        return 2;
    case ErrorCode::input:
        return 3;
    case ErrorCode::unsupported:
    case ErrorCode::out_of_memory:
    case ErrorCode::device_lost:
    case ErrorCode::vulkan:
        return 4;
    case ErrorCode::internal:
        break;
    }
    return 5;
}

int fail(Error error) {
    std::ranges::replace(error.message, '\n', ' ');
    std::fprintf(stderr, "sfumato-bench: %s\n", error.message.c_str());
    return exit_code(error.code);
}

Result<void> run(const bench::Options& options) {
    using namespace bench;
    const Output output(options.json);
    if (options.command == "list")
        return list_all(output);
    if (options.command == "sort" || options.command == "particles") {
        auto rig = Rig::create(options.rig);
        if (!rig)
            return rig.error();
        const auto done = options.command == "sort" ? measure_sort(**rig, options, output)
                                                    : measure_particles(**rig, options, output);
        return done ? (*rig)->check_validation() : done;
    }
    // Names first: a typing error should not cost the time of opening a device.
    const auto variants = make_variants(options.variants);
    if (!variants)
        return variants.error();
    auto sources = open_sources(options.scenes, options.raw_files, !options.variants.effect.empty());
    if (!sources)
        return sources.error();
    std::erase_if(*sources, [&](const auto& source) {
        return std::ranges::none_of(*variants, [&](const Variant& v) { return source->suits(v.effect->name); });
    });
    if (sources->empty())
        return Error{ErrorCode::invalid_argument,
                     "no scene is made for this effect, and no file holds its truth: name some with --scene"};
    auto rig = Rig::create(options.rig);
    if (!rig)
        return rig.error();
    Result<void> done = Error{ErrorCode::internal, "the command " + options.command + " does nothing"};
    if (options.command == "times")
        done = measure_times(**rig, options, *variants, *sources, output);
    else if (options.command == "quality")
        done = measure_quality(**rig, options, *variants, *sources, output);
    else if (options.command == "frontier")
        done = measure_frontier(**rig, options, *variants, *sources, output);
    else if (options.command == "tune")
        done = tune(**rig, options, *variants, *sources, output);
    return done ? (*rig)->check_validation() : done;
}

} // namespace

int main(int argc, char** argv) {
    try {
        const auto parsed = bench::parse_options(argc, argv);
        if (!parsed)
            return fail(parsed.error());
        if (parsed->is_done)
            return 0;
        if (auto done = run(parsed->options); !done)
            return fail(done.error());
        return 0;
    } catch (const std::exception& exception) { // the standard library's, such as a lack of memory
        return fail({ErrorCode::internal, exception.what()});
    }
}
