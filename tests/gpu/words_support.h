// Plans on buffers: words go in and come out through images.
#pragma once

#include "filters/device_count.h"
#include "tests/gpu/gpu_test.h"

#include <cstdint>
#include <vector>

namespace sfumato::test {

using Words = std::vector<uint32_t>;

// Builds one plan and runs it, with every buffer that was asked for read back.
class WordsRig {
  public:
    explicit WordsRig(Context& context) : context_(context), planner_("words") {}

    Planner& planner() { return planner_; }

    // A buffer that holds these words (at least one).
    ResourceId upload(const Words& words);

    // Reads the first `number` words of the buffer back; the result stands in results()[as called].
    void read(ResourceId buffer, size_t number);

    // Runs `times` times; every run must give the same words. Once per rig.
    const std::vector<Words>& run(int times = 1);

    // What a buffer holds that nobody wrote, under ContextInfo::poison.
    static uint32_t poisoned(int poison) { return 0x01010101u * static_cast<uint32_t>(poison & 0xff); }

  private:
    struct Output {
        size_t image, number;
    };
    size_t add_image(size_t words);
    Context& context_;
    Planner planner_;
    std::vector<apps::HostImage> images_;
    std::vector<Output> outputs_;
    std::vector<Words> results_;
};

} // namespace sfumato::test
