// Runs a fuzz target without libFuzzer: every file of a corpus folder, and mutations of each, the same ones every time.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

constexpr int mutations_of_each = 400;

void mutate(std::vector<uint8_t>& bytes, std::mt19937& random) {
    for (uint32_t change = 0, count = 1 + random() % 4; change < count && !bytes.empty(); ++change) {
        const size_t at = random() % bytes.size();
        const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
        switch (random() % 6) {
        case 0:
            bytes[at] = static_cast<uint8_t>(random());
            break;
        case 1:
            bytes[at] ^= static_cast<uint8_t>(1u << random() % 8);
            break;
        case 2:
            bytes.resize(at);
            break;
        case 3:
            bytes.erase(place);
            break;
        case 4:
            bytes.insert(place, 1 + random() % 8, static_cast<uint8_t>(random()));
            break;
        default: // sizes and counts like these
            bytes[at] = random() % 2 ? 0xff : 0x7f;
        }
    }
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: %s CORPUS\n", argv[0]);
        return 2;
    }
    size_t files = 0, runs = 0;
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator(argv[1]))
        paths.push_back(entry.path());
    for (const auto& path : paths) {
        std::ifstream file(path, std::ios::binary);
        const std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
        std::mt19937 random(static_cast<uint32_t>(bytes.size()));
        ++files;
        for (int i = 0; i <= mutations_of_each; ++i, ++runs) {
            std::vector<uint8_t> changed = bytes;
            if (i > 0)
                mutate(changed, random);
            LLVMFuzzerTestOneInput(changed.data(), changed.size());
        }
    }
    std::printf("%zu files, %zu runs\n", files, runs);
    return files > 0 ? 0 : 1;
}
