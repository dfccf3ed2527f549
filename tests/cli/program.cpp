// Processes, files and pictures for the tests of the command line.
#include "tests/cli/program.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>

namespace sfumato::cli_tests {

namespace fs = std::filesystem;

size_t ProgramResult::error_lines() const {
    return static_cast<size_t>(std::count(error.begin(), error.end(), '\n'));
}

namespace {

std::string read_text(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

// Between fork and exec: only calls that are safe there.
[[noreturn]] void become(const fs::path& folder, const fs::path& out, const fs::path& error, char* const* arguments) {
    const int out_file = ::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int error_file = ::open(error.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (out_file < 0 || error_file < 0 || ::dup2(out_file, 1) < 0 || ::dup2(error_file, 2) < 0 ||
        ::chdir(folder.c_str()) != 0)
        ::_exit(126);
    ::execvp(arguments[0], arguments);
    ::_exit(127);
}

float texture(float x, float y) {
    return 0.5f + 0.25f * std::sin(x * 0.9f) + 0.2f * std::sin(y * 1.3f + x * 0.4f);
}

void add_matrix(media::ExrPart& part, const char* name, const std::array<float, 16>& rows) {
    media::ExrAttribute attribute{name, "m44f", std::vector<char>(sizeof rows)};
    std::memcpy(attribute.bytes.data(), rows.data(), sizeof rows);
    part.attributes.push_back(attribute);
}

void add_camera(media::ExrPart& part, int number) {
    const float x = -1.5f * static_cast<float>(number);
    // +Z forward, 90° wide and high; rows of matrices for row vectors.
    add_matrix(part, "worldToCamera", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, x, 0, 0, 1});
    add_matrix(part, "worldToNDC", {0.5f, 0, 0, 0, 0, -0.5f, 0, 0, -0.5f, -0.5f, 1, -1, 0.5f * x, 0, 0, 0});
}

} // namespace

media::ExrImage make_frame(int number, const FrameOptions& options) {
    media::ExrPart part;
    part.data_window = {0, 0, options.width - 1, options.height - 1};
    part.display_window = part.data_window;
    const size_t count = part.pixel_count();
    const int left = 10 + 6 * number, top = 12 + 2 * number;
    std::vector<float> colour(count), depth(count, 10.0f), x(count, 0.0f), y(count, 0.0f);
    for (size_t i = 0; i < count; ++i) {
        const int px = static_cast<int>(i) % options.width, py = static_cast<int>(i) / options.width;
        const bool inside = px >= left && px < left + 24 && py >= top && py < top + 24;
        colour[i] = inside
                        ? texture(static_cast<float>(px - left), static_cast<float>(py - top))
                        : options.background * (1.0f + texture(static_cast<float>(px) * 0.7f, static_cast<float>(py)));
        depth[i] = inside ? 5.0f : 10.0f;
        // Previous minus current, y up: (-6, +2).
        x[i] = inside ? -6.0f : 0.0f;
        y[i] = inside ? 2.0f : 0.0f;
    }
    for (const char* letter : {"View.Combined.R", "View.Combined.G", "View.Combined.B"})
        part.set_channel(letter, colour, media::PixelType::float32);
    part.set_channel("View.Combined.A", std::vector<float>(count, 1.0f), media::PixelType::float32);
    part.set_channel("View.Extra.V", colour, media::PixelType::float32);
    if (options.depth)
        part.set_channel("View.Depth.Z", depth, media::PixelType::float32);
    if (options.motion) {
        part.set_channel(options.motion_layer + ".X", x, media::PixelType::float32);
        part.set_channel(options.motion_layer + ".Y", y, media::PixelType::float32);
        if (!options.two_channels) {
            part.set_channel(options.motion_layer + ".Z", x, media::PixelType::float32);
            part.set_channel(options.motion_layer + ".W", y, media::PixelType::float32);
        }
    }
    if (options.camera)
        add_camera(part, number);
    part.set_string_attribute("artist", "somebody");
    media::ExrImage image;
    image.parts.push_back(part);
    return image;
}

ProgramTest::ProgramTest() {
    std::string pattern = (fs::temp_directory_path() / "sfumato-cli-XXXXXX").string();
    if (::mkdtemp(pattern.data()))
        folder_ = pattern;
}

ProgramTest::~ProgramTest() {
    std::error_code ignored;
    if (!folder_.empty())
        fs::remove_all(folder_, ignored);
}

ProgramResult ProgramTest::run(const std::vector<std::string>& arguments,
                               const std::vector<std::string>& environment) const {
    // "env NAME=value … program argument …", with the streams beside the folder so that files() does not see them.
    std::vector<std::string> words = {"env"};
    words.insert(words.end(), environment.begin(), environment.end());
    words.emplace_back(SFUMATO_CLI_PATH);
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> pointers;
    for (std::string& word : words)
        pointers.push_back(word.data());
    pointers.push_back(nullptr);
    const fs::path out = folder_.string() + ".out", error = folder_.string() + ".error";
    const pid_t child = ::fork();
    if (child == 0)
        become(folder_, out, error, pointers.data());
    int status = 0;
    if (child < 0 || ::waitpid(child, &status, 0) != child)
        return {};
    ProgramResult result{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_text(out),
                         read_text(error)};
    std::error_code ignored;
    fs::remove(out, ignored);
    fs::remove(error, ignored);
    return result;
}

void ProgramTest::expect_error(const std::vector<std::string>& arguments, int code,
                               const std::vector<std::string>& parts,
                               const std::vector<std::string>& environment) const {
    const ProgramResult result = run(arguments, environment);
    std::string words;
    for (const std::string& argument : arguments)
        words += " " + argument;
    EXPECT_EQ(result.code, code) << "sfumato" << words << "\n" << result.error;
    EXPECT_EQ(result.error_lines(), 1u) << "sfumato" << words << "\n" << result.error;
    EXPECT_TRUE(result.error.starts_with("sfumato: ")) << result.error;
    for (const std::string& part : parts)
        EXPECT_NE(result.error.find(part), std::string::npos) << "no '" << part << "' in: " << result.error;
}

void ProgramTest::write_frames(int first, int last, const FrameOptions& options) const {
    for (int number = first; number <= last; ++number) {
        char name[32];
        std::snprintf(name, sizeof name, "shot.%04d.exr", number);
        const auto written = media::write_exr(path(name), make_frame(number, options));
        ASSERT_TRUE(written) << written.error().message;
    }
}

std::string ProgramTest::read(const std::string& name) const {
    return read_text(path(name));
}

void ProgramTest::write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
}

std::vector<std::string> ProgramTest::files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder_))
        if (entry.is_regular_file())
            names.push_back(fs::relative(entry.path(), folder_).string());
    std::sort(names.begin(), names.end());
    return names;
}

} // namespace sfumato::cli_tests
