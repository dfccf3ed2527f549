// Words of buffers through images.
#include "tests/gpu/words_support.h"

#include "sfumato/executor.h"
#include "shaders/words_test.h"

#include <cstring>

namespace sfumato::test {

namespace {
constexpr uint32_t row = 1024; // as in words_test.comp
}

size_t WordsRig::add_image(size_t words) {
    const Extent extent{row, static_cast<uint32_t>((words + row - 1) / row)};
    images_.push_back(expect_value(device().create_image(VK_FORMAT_R8G8B8A8_UNORM, extent), "create_image"));
    return images_.size() - 1;
}

ResourceId WordsRig::upload(const Words& words) {
    const size_t image = add_image(words.size());
    std::vector<std::byte> bytes(size_t{4} * row * images_[image].extent().height);
    std::memcpy(bytes.data(), words.data(), words.size() * 4);
    expect_done(device().upload_bytes(images_[image], bytes), "upload");
    const auto number = static_cast<uint32_t>(words.size());
    const ResourceId source = planner_.host("source", static_cast<uint32_t>(image), images_[image].image());
    const ResourceId buffer = planner_.buffer("uploaded", 4 * words.size());
    Pass& pass = planner_.pass("load", shaders::words_test::load);
    pass.specialization = {0, number};
    pass.accesses = {{source, AccessKind::fetch}, write_buffer(buffer)};
    pass.dispatch = {DispatchKind::texels, source};
    return buffer;
}

void WordsRig::read(ResourceId buffer, size_t number) {
    const size_t image = add_image(number);
    const ResourceId target = planner_.host("target", static_cast<uint32_t>(image), images_[image].image());
    Pass& pass = planner_.pass("store", shaders::words_test::store);
    pass.specialization = {0, static_cast<uint32_t>(number)};
    pass.accesses = {read_buffer(buffer), {target, AccessKind::write}};
    pass.dispatch = {DispatchKind::texels, target};
    outputs_.push_back({image, number});
}

const std::vector<Words>& WordsRig::run(int times) {
    const Plan plan = std::move(planner_).finish();
    const auto executor = expect_value(Executor::create(context_), "Executor::create");
    std::vector<Image> images;
    for (const apps::HostImage& image : images_)
        images.push_back(image.image());
    for (int i = 0; i < times; ++i) {
        run_commands([&](VkCommandBuffer commands) {
            expect_done(executor->execute(commands, plan, images, static_cast<uint64_t>(i)), "execute");
        });
        std::vector<Words> results;
        for (const Output& output : outputs_) {
            const auto bytes = expect_value(device().readback_bytes(images_[output.image]), "readback");
            Words words(output.number);
            std::memcpy(words.data(), bytes.data(), words.size() * 4);
            results.push_back(std::move(words));
        }
        if (i > 0) {
            EXPECT_EQ(results, results_) << "run " << i << " differs from the first";
        }
        results_ = std::move(results);
    }
    return results_;
}

} // namespace sfumato::test
