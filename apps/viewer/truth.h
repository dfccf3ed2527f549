// Ground truth of what is seen, gathered in slices while nothing changes, so that the window stays alive meanwhile.
#pragma once

#include "apps/viewer/picture_renderer.h"

#include <optional>
#include <string>

namespace sfumato::viewer {

inline constexpr int sub_frames_a_slice = 4;
inline constexpr int rays_a_slice = 16;

// One slice of the work.
struct TruthSlice {
    double frame = 0.0; // the moment to record
    scene::RenderOptions options;
    int share = 0; // sub-frames or rays
};

// The open time of a shutter in `slices` equal parts, each with its share of the sub-frames: their mean is the truth of
// all sub-frames. Parts far apart in time come first one after the other, so that early means are of use.
std::vector<TruthSlice> shutter_slices(int frame, const scene::Shutter& shutter, int slices);
// Independent rays, a share of them in each slice.
std::vector<TruthSlice> ray_slices(int frame, const scene::OcclusionTruth& occlusion, int slices);

// How far the effect is from what has been gathered.
struct TruthError {
    double rmse = 0.0;
    double psnr = 0.0; // dB
};

class Truth {
  public:
    explicit Truth(PictureRenderer& renderer) : renderer_(renderer) {}

    // One more slice of the truth that the model asks for, and how far the rendered picture is from what there is;
    // begins anew when the scene, the camera or the settings have changed. Whether there was something to do. Waits for
    // the device.
    Result<bool> gather(const Model& model, const PictureRequest& request);

    // Nothing unless it is the truth of what the request asks for.
    Image mean(const Model& model, const PictureRequest& request) const;
    int done() const { return done_; } // sub-frames or rays
    int total() const { return total_; }
    const std::optional<TruthError>& error() const { return error_; }

  private:
    Result<void> begin(const Model& model, const PictureRequest& request);
    Result<void> add(const TruthSlice& slice, const PictureRequest& request);
    Result<void> measure(const Model& model);

    PictureRenderer& renderer_;
    TruthKind kind_ = TruthKind::none;
    std::string key_, measured_;
    std::vector<TruthSlice> slices_;
    size_t next_ = 0;
    int done_ = 0, total_ = 0;
    std::vector<double> sum_;
    apps::HostImage slice_, mean_;
    std::optional<TruthError> error_;
    uint64_t count_ = uint64_t{1} << 40; // the source's frames, apart from those of the pictures
};

} // namespace sfumato::viewer
