// Rules of the source tree that no compiler checks: what the library may include and call, and which layer may see
// which.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

namespace {

namespace fs = std::filesystem;
const fs::path root = SFUMATO_SOURCE_DIR;

std::string read(const fs::path& path) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

std::string without_comments(const std::string& text) {
    static const std::regex line_comment("//[^\n]*");
    return std::regex_replace(text, line_comment, "");
}

std::vector<fs::path> sources(const fs::path& folder) {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        const std::string extension = entry.path().extension().string();
        if (extension == ".h" || extension == ".cpp" || extension == ".comp" || extension == ".glsl")
            found.push_back(entry.path());
    }
    return found;
}

std::vector<std::string> includes(const std::string& text) {
    static const std::regex include("#include [<\"]([^>\"]+)[>\"]");
    std::vector<std::string> found;
    for (std::sregex_iterator i(text.begin(), text.end(), include), end; i != end; ++i)
        found.push_back((*i)[1]);
    return found;
}

TEST(Layering, the_library_has_no_thread_file_clock_or_stream) {
    const char* forbidden[] = {"thread",         "mutex",  "atomic",   "condition_variable", "future",    "chrono",
                               "ctime",          "time.h", "fstream",  "iostream",           "sstream",   "filesystem",
                               "unistd.h",       "random", "typeinfo", "exception",          "stdexcept", "dlfcn.h",
                               "vulkan/vulkan.h"};
    size_t files = 0;
    for (const fs::path& folder : {root / "include", root / "src"})
        for (const fs::path& path : sources(folder)) {
            ++files;
            for (const std::string& header : includes(read(path)))
                for (const char* name : forbidden)
                    EXPECT_NE(header, name) << path;
        }
    EXPECT_GT(files, 20u);
}

TEST(Layering, the_library_calls_nothing_that_ends_or_prints) {
    // As whole words: `terminate` in a longer name is none of ours.
    const std::regex forbidden(
        "\\b(throw|try|catch|abort|assert|exit|terminate|fopen|getenv|system|rand|srand|time|"
        "printf|puts|dynamic_cast|typeid|thread_local)\\s*\\(|\\b(throw|try|catch|dynamic_cast|typeid|thread_local)\\b"
        "|std::(cout|cerr|clog)");
    for (const fs::path& folder : {root / "include", root / "src"})
        for (const fs::path& path : sources(folder)) {
            if (path.extension() != ".h" && path.extension() != ".cpp")
                continue;
            const std::string text = without_comments(read(path));
            std::istringstream lines(text);
            for (std::string line; std::getline(lines, line);) {
                static const std::regex strings("\"[^\"]*\"");
                EXPECT_FALSE(std::regex_search(std::regex_replace(line, strings, ""), forbidden))
                    << path << ": " << line;
            }
        }
}

// include < core < gpu < filters < effects; scene and media see the public headers only.
TEST(Layering, no_layer_includes_one_above_it) {
    const std::vector<std::string> order = {"core", "gpu", "filters", "effects"};
    for (size_t layer = 0; layer < order.size(); ++layer) {
        if (!fs::exists(root / "src" / order[layer]))
            continue;
        for (const fs::path& path : sources(root / "src" / order[layer]))
            for (const std::string& header : includes(read(path)))
                for (size_t above = layer + 1; above < order.size(); ++above) {
                    // The list of effects names them all.
                    const bool is_list = path.filename() == "effect.cpp" && header.find("sfumato/effects/") == 0;
                    EXPECT_TRUE(is_list || header.find(order[above] + "/") != 0) << path << " includes " << header;
                }
    }
    for (const char* folder : {"include", "scene", "media"})
        for (const fs::path& path : sources(root / folder))
            for (const std::string& header : includes(read(path)))
                for (const std::string& inside : order)
                    EXPECT_NE(header.find(inside + "/"), 0u) << path << " includes " << header;
}

TEST(Layering, every_shader_names_its_passes) {
    for (const fs::path& path : sources(root / "src"))
        EXPECT_TRUE(path.extension() != ".comp" || read(path).rfind("// passes: ", 0) == 0) << path;
}

// isnan and isinf may be optimised away; pow of a negative and normalize of zero are undefined.
TEST(Layering, shaders_test_numbers_by_their_bits) {
    const std::regex forbidden("\\b(isnan|isinf)\\s*\\(");
    for (const fs::path& path : sources(root / "src"))
        EXPECT_TRUE(path.extension() == ".cpp" || path.extension() == ".h" ||
                    !std::regex_search(without_comments(read(path)), forbidden))
            << path;
}

// The integration in the umbrella header's comment is compiled and run by the consumer project: they must be equal.
TEST(Documentation, the_header_shows_the_integration_that_is_tested) {
    const std::string consumer = read(root / "tests/integration/consumer/main.cpp");
    const std::string begin = "// [sfumato", end = "// sfumato]";
    std::vector<std::string> wanted;
    std::istringstream lines(consumer);
    bool inside = false;
    for (std::string line; std::getline(lines, line);) {
        const size_t first = line.find_first_not_of(' ');
        const std::string trimmed = first == std::string::npos ? "" : line.substr(first);
        if (trimmed.rfind(end, 0) == 0)
            inside = false;
        else if (trimmed.rfind(begin, 0) == 0)
            inside = true;
        else if (inside)
            wanted.push_back(trimmed);
    }
    ASSERT_GE(wanted.size(), 10u);
    EXPECT_LE(wanted.size(), 30u);
    const std::string header = read(root / "include/sfumato/sfumato.h");
    std::string shown;
    std::istringstream header_lines(header);
    for (std::string line; std::getline(header_lines, line);) {
        if (line.rfind("//", 0) != 0)
            continue;
        const size_t first = line.find_first_not_of(' ', 2);
        shown += (first == std::string::npos ? "" : line.substr(first)) + "\n";
    }
    std::string all;
    for (const std::string& line : wanted)
        all += line + "\n";
    EXPECT_NE(shown.find(all), std::string::npos) << "the header must show these lines:\n" << all;
}

} // namespace
