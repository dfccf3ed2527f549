// Constants structs have the layout in C++ that the shaders' SPIR-V gives them, as an independent reader sees it.
#include <cstddef>

struct ConstantsMember {
    const char* shader; // the .comp file's stem
    const char* name;   // of the struct
    const char* type;
    const char* member;
    size_t offset;
    size_t size; // of the struct
};

#include "constants_layouts.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

TEST(ConstantsLayout, structs_hold_only_types_that_both_languages_lay_out_alike) {
    size_t structs = 0;
    std::string last;
    for (const ConstantsMember& member : constants_members) {
        EXPECT_EQ(member.size % 16, 0u) << member.name;
        structs += last != member.name;
        last = member.name;
    }
    EXPECT_GE(structs, 1u);
}

#ifdef SFUMATO_SPIRV_CROSS
std::string reflect(const fs::path& path) {
    const std::string command = std::string(SFUMATO_SPIRV_CROSS) + " '" + path.string() + "' --reflect";
    FILE* pipe = popen(command.c_str(), "r");
    std::string text;
    std::array<char, 4096> buffer;
    while (pipe) {
        const size_t count = fread(buffer.data(), 1, buffer.size(), pipe);
        if (count == 0)
            break;
        text.append(buffer.data(), count);
    }
    if (pipe)
        pclose(pipe);
    return text;
}

struct Member {
    std::string type;
    size_t offset;
};

// The members of the uniform block at set 1, binding 0; none where the shader has no constants. A block that holds just
// one struct is that struct.
std::vector<Member> block_members(const std::string& json) {
    static const std::regex block("\"ubos\" : \\[\\s*\\{\\s*\"type\" : \"(_[0-9]+)\"");
    // An array has its numbers of elements between type and offset.
    static const std::regex member("\"type\" : \"([a-z0-9_]+)\",(?:\\s*\"array[a-z_]*\" : \\[[^\\]]*\\],)*"
                                   "\\s*\"offset\" : ([0-9]+)");
    std::smatch found;
    if (!std::regex_search(json, found, block))
        return {};
    std::string type = found[1];
    for (int depth = 0; depth < 3; ++depth) {
        const size_t begin = json.find("\"" + type + "\" : {");
        const size_t end = json.find("\n        }", begin);
        const std::string body = json.substr(begin, end - begin);
        std::vector<Member> members;
        for (std::sregex_iterator i(body.begin(), body.end(), member), last; i != last; ++i)
            members.push_back({(*i)[1], std::stoul((*i)[2])});
        if (members.size() != 1 || members[0].type[0] != '_')
            return members;
        type = members[0].type;
    }
    return {};
}

TEST(ConstantsLayout, agrees_with_the_spirv) {
    size_t compared = 0;
    for (const auto& entry : fs::directory_iterator(SFUMATO_SHADER_DIR)) {
        if (entry.path().extension() != ".spv")
            continue;
        SCOPED_TRACE(entry.path().filename().string());
        const std::string stem = entry.path().filename().string().substr(0, entry.path().filename().string().find('.'));
        const auto members = block_members(reflect(entry.path()));
        std::vector<const ConstantsMember*> wanted;
        for (const ConstantsMember& member : constants_members)
            if (member.shader == stem)
                wanted.push_back(&member);
        if (members.empty() || wanted.empty()) {
            EXPECT_TRUE(members.empty()) << "has constants, but there is no " << stem << "_shared.h";
            continue;
        }
        ++compared;
        ASSERT_EQ(members.size(), wanted.size());
        for (size_t i = 0; i < members.size(); ++i) {
            EXPECT_EQ(members[i].type, wanted[i]->type) << wanted[i]->member;
            EXPECT_EQ(members[i].offset, wanted[i]->offset) << wanted[i]->member;
        }
    }
    EXPECT_GE(compared, 1u);
}
#else
TEST(ConstantsLayout, agrees_with_the_spirv) {
    GTEST_SKIP() << "spirv-cross is not installed";
}
#endif

} // namespace
