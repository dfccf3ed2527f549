// Runs the built program in a folder of its own, and makes small frames for it.
#pragma once

#include "media/exr_file.h"

#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace sfumato::cli_tests {

struct ProgramResult {
    int code = -1; // exit code; 128 + signal if it died of one
    std::string out;
    std::string error;

    // The number of lines on standard error.
    size_t error_lines() const;
};

struct FrameOptions {
    int width = 96;
    int height = 64;
    bool depth = true;
    bool motion = true;
    std::string motion_layer = "View.Vector"; // X Y Z W in Blender's convention
    bool two_channels = false;                // X and Y alone
    bool camera = false;                      // attributes of a camera that moves to the right
    float background = 0.1f;
};

// A textured square that moves 6 pixels to the right and 2 down a frame before a textured wall.
media::ExrImage make_frame(int number, const FrameOptions& options = {});

class ProgramTest : public ::testing::Test {
  protected:
    ProgramTest();
    ~ProgramTest() override;

    // `environment`: "NAME=value" on top of the test's own.
    ProgramResult run(const std::vector<std::string>& arguments,
                      const std::vector<std::string>& environment = {}) const;

    // Expects exit code `code` and exactly one line on standard error, which begins with "sfumato: " and holds `parts`.
    void expect_error(const std::vector<std::string>& arguments, int code, const std::vector<std::string>& parts,
                      const std::vector<std::string>& environment = {}) const;

    // Writes shot.0001.exr and so on.
    void write_frames(int first, int last, const FrameOptions& options = {}) const;

    std::filesystem::path path(const std::string& name) const { return folder_ / name; }
    std::string read(const std::string& name) const;
    void write(const std::string& name, const std::string& text) const;
    bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }

    // Names of all files below the folder, sorted: finds temporary files that were left behind.
    std::vector<std::string> files() const;

  private:
    std::filesystem::path folder_;
};

} // namespace sfumato::cli_tests
