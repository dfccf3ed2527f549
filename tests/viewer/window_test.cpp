// The viewer's window on a virtual display with software Vulkan, used by mouse and keys as a person would.
#include "tests/cli/program.h"
#include "tests/viewer/display.h"

#include <algorithm>
#include <sstream>

namespace sfumato::viewer_tests {
namespace {

// Small, so that software Vulkan keeps up: a picture of 300×166 pixels beside the panel.
constexpr int window_width = 600, window_height = 400;
const std::string window_size = "600x400";
const std::vector<std::string> scene = {"fairground", "--effects", "ambient-occlusion", "--scale", "0.5"};

class ViewerWindow : public cli_tests::ProgramTest {
  protected:
    void SetUp() override {
        std::string missing;
        if (!Display::is_possible(missing))
            GTEST_SKIP() << missing << " is not installed: the viewer's window is not tested";
        display_.emplace(path(""), 800, 600);
    }

    void start(const std::vector<std::string>& more = {}) {
        std::vector<std::string> arguments = {SFUMATO_CLI_PATH, "view"};
        arguments.insert(arguments.end(), scene.begin(), scene.end());
        arguments.insert(arguments.end(), {"--size", window_size, "--validate", "--widget-log", log().string(), "-o",
                                           path("saved.png").string()});
        arguments.insert(arguments.end(), more.begin(), more.end());
        viewer_ = Process(arguments, {"DISPLAY=" + display_->name(), "XDG_SESSION_TYPE=x11"}, path("viewer.txt"));
        ASSERT_TRUE(eventually([&] { return widgets().widgets.contains("picture") || !viewer_.is_running(); }));
        ASSERT_TRUE(viewer_.is_running()) << read("viewer.txt");
        rest();
    }

    std::filesystem::path log() const { return path("widgets.json"); }
    WidgetState widgets() const { return read_widgets(log()); }
    double state(const std::string& name) const {
        const WidgetState now = widgets();
        const auto found = now.state.find(name);
        return found == now.state.end() ? -1.0 : found->second;
    }

    // Until nothing more is rendered and all that was is on the screen.
    void rest() {
        double turns = state("turns");
        ASSERT_TRUE(eventually([&] { return state("busy") == 0.0 && state("turns") >= turns + 3.0; }));
    }

    std::string place(const std::string& widget, double share = 0.5) {
        std::array<double, 4> at{};
        EXPECT_TRUE(eventually([&] {
            const WidgetState now = widgets();
            const auto found = now.widgets.find(widget);
            if (found == now.widgets.end())
                return false;
            at = found->second;
            return true;
        })) << "no widget "
            << widget;
        return std::to_string(static_cast<int>(at[0] + at[2] * share)) + " " +
               std::to_string(static_cast<int>(at[1] + at[3] * 0.5));
    }

    void click(const std::string& widget, double share = 0.5) {
        display_->act("mousemove " + place(widget, share) + " sleep 0.15 mousedown 1 sleep 0.15 mouseup 1");
        rest();
    }

    void drag(const std::string& widget, double from, double to) {
        display_->act("mousemove " + place(widget, from) + " sleep 0.15 mousedown 1 sleep 0.15 mousemove " +
                      place(widget, to) + " sleep 0.3 mouseup 1");
        rest();
    }

    void quit() {
        display_->act("mousemove 5 300 key ctrl+q");
        EXPECT_EQ(viewer_.wait(), 0) << read("viewer.txt");
        EXPECT_EQ(read("viewer.txt"), "");
    }

    std::array<int, 4> area() {
        const auto found = widgets().widgets.at("picture");
        return {static_cast<int>(found[0]), static_cast<int>(found[1]), static_cast<int>(found[2]),
                static_cast<int>(found[3])};
    }

    // The lower half of the picture: no labels and, at the edge of the screen, no pointer.
    Difference of_pictures(const Pixels& a, const Pixels& b) {
        const auto [x, y, width, height] = area();
        return compare(a, b, x, y + height / 2, width, height / 2);
    }

    Pixels shown() {
        display_->act("mousemove 799 599 sleep 0.1"); // out of the window
        rest();
        return display_->screen();
    }

    std::optional<Display> display_;
    Process viewer_;
};

TEST_F(ViewerWindow, shows_what_headless_writes_and_saves_it) {
    start();
    const Pixels screen = shown();
    std::vector<std::string> arguments = {"view"};
    arguments.insert(arguments.end(), scene.begin(), scene.end());
    arguments.insert(arguments.end(), {"--size", window_size, "--headless", "--ui", "--split", "0.5", "-o", "h.png"});
    ASSERT_EQ(run(arguments).code, 0);
    EXPECT_EQ(of_pictures(screen, read_png(path("h.png"))).largest, 0);
    click("tab Files");
    click("save png");
    ASSERT_TRUE(eventually([&] { return exists("saved.png"); }));
    const Pixels saved = read_png(path("saved.png"));
    EXPECT_EQ(saved.width, static_cast<int>(state("picture_width")));
    EXPECT_EQ(saved.height, static_cast<int>(state("picture_height")));
    // Each pixel of the saved picture is a block of four in the window.
    const auto [x, y, width, height] = area();
    EXPECT_EQ(saved.width * 2, width);
    for (int row = 0; row < height; row += 2)
        for (int column = 0; column < width; column += 2)
            if (std::abs(column - width / 2) > 4 && row > 40) {
                ASSERT_EQ(saved.at(column / 2, row / 2), screen.at(x + column, y + row)) << column << " " << row;
            }
    quit();
}

TEST_F(ViewerWindow, a_parameter_changes_the_picture_and_resets) {
    start();
    const Pixels before = shown();
    const double pictures = state("pictures");
    drag("ambient-occlusion.intensity", 0.12, 0.9);
    EXPECT_GT(state("pictures"), pictures);
    const Pixels after = shown();
    EXPECT_GT(of_pictures(before, after).mean, 2.0);
    click("ambient-occlusion.intensity reset");
    EXPECT_EQ(of_pictures(before, shown()).largest, 0);
    click("ambient-occlusion"); // off: both sides are the same
    click("split");
    const Pixels off = shown();
    click("right");
    click("right before");
    EXPECT_EQ(of_pictures(off, shown()).largest, 0);
    quit();
}

TEST_F(ViewerWindow, camera_time_divider_and_size) {
    start();
    const Pixels before = shown();
    drag("divider", 0.5, 0.5);
    const auto divider = widgets().widgets.at("divider");
    display_->act("mousemove " + place("divider") + " sleep 0.15 mousedown 1 sleep 0.15 mousemove_relative -- -60 0 " +
                  "sleep 0.3 mouseup 1");
    rest();
    EXPECT_NEAR(widgets().widgets.at("divider")[0], divider[0] - 60, 2.0);
    drag("picture", 0.7, 0.8); // circles the scene
    const Pixels orbited = shown();
    EXPECT_GT(of_pictures(before, orbited).mean, 5.0);
    // The command that the viewer tells makes the picture that it saves.
    click("split");
    click("tab Files");
    click("save png");
    ASSERT_TRUE(eventually([&] { return exists("saved.png"); }));
    std::istringstream command(widgets().command);
    std::vector<std::string> words;
    for (std::string word; command >> word;)
        words.push_back(word);
    ASSERT_GT(words.size(), 4u);
    EXPECT_NE(std::ranges::find(words, "--viewpoint"), words.end());
    words.erase(words.begin()); // the program
    words.back() = "rendered.png";
    ASSERT_EQ(run(words).code, 0) << widgets().command;
    const Pixels saved = read_png(path("saved.png")), rendered = read_png(path("rendered.png"));
    EXPECT_LE(compare(saved, rendered, 0, 0, saved.width, saved.height).largest, 1);
    const double frame = state("frame");
    display_->act("mousemove 200 300 sleep 0.1 key Right");
    ASSERT_TRUE(eventually([&] { return state("frame") == frame + 1.0; }));
    display_->act("key space");
    ASSERT_TRUE(eventually([&] { return state("playing") == 1.0 && state("frame") != frame + 1.0; }));
    display_->act("key space");
    ASSERT_TRUE(eventually([&] { return state("playing") == 0.0; }));
    const double width = state("picture_width");
    display_->act("search --name Sfumato windowsize 700 420");
    ASSERT_TRUE(eventually([&] { return state("picture_width") > width; }));
    rest();
    display_->act("search --name Sfumato windowunmap sleep 0.3 windowmap sleep 0.3");
    const Pixels resized = shown();
    const auto [x, y, right, bottom] = area();
    EXPECT_GT(compare(resized, orbited, 0, 0, window_width, window_height).mean, 1.0);
    // The picture fills its area up to the corner.
    EXPECT_NE(resized.at(x + right - 3, y + bottom - 3), resized.at(798, 598));
    quit();
}

} // namespace
} // namespace sfumato::viewer_tests
