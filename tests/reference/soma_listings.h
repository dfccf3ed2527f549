// The shader listings of Frictional Games, SSAO and Temporal Blur, 2014, transcribed as literally as C++ allows. Names
// and order are the article's.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace sfumato::reference {

struct SomaVec2 {
    double x = 0.0, y = 0.0;
};
struct SomaVec3 {
    double x = 0.0, y = 0.0, z = 0.0;
};

// "SSAO main loop". `view_position(x, y)` is GetViewPosition, `rotate(v)` is mtxRot * v, `vUV0` the first vector.
template <class ViewPosition, class Rotate>
double soma_listing_ssao(ViewPosition view_position, Rotate rotate, SomaVec2 vUV0, SomaVec2 frag_coord, SomaVec3 vPos,
                         SomaVec3 vNormal, double afStepSizeMax, double afRadius) {
    const double fNegInvRadius = -1.0 / afRadius;
    const double fStepSize = afStepSizeMax * afRadius / vPos.z;
    const double fStepSizePart = 0.5 * fStepSize / (2 + 16.0);
    double fAO = 0.0;
    for (double d = 0.0; d < 16.0; d += 4.0) {
        const double vOffset[4] = {(d + 2) * fStepSizePart, (d + 3) * fStepSizePart, (d + 4) * fStepSizePart,
                                   (d + 5) * fStepSizePart};
        const SomaVec2 vUV1 = rotate(vUV0);
        vUV0 = rotate(vUV1);
        const SomaVec3 seen[4] = {
            view_position(frag_coord.x + vUV1.x * vOffset[0], frag_coord.y + vUV1.y * vOffset[0]),
            view_position(frag_coord.x - vUV1.x * vOffset[1], frag_coord.y - vUV1.y * vOffset[1]),
            view_position(frag_coord.x + vUV0.x * vOffset[2], frag_coord.y + vUV0.y * vOffset[2]),
            view_position(frag_coord.x - vUV0.x * vOffset[3], frag_coord.y - vUV0.y * vOffset[3])};
        for (const SomaVec3& each : seen) {
            const SomaVec3 vDelta = {each.x - vPos.x, each.y - vPos.y, each.z - vPos.z};
            const double fDistanceSqr = vDelta.x * vDelta.x + vDelta.y * vDelta.y + vDelta.z * vDelta.z;
            const double fInvertedLength = 1.0 / std::sqrt(fDistanceSqr);
            const double fFalloff = 1.0 + fDistanceSqr * fInvertedLength * fNegInvRadius;
            const double fAngle =
                (vNormal.x * vDelta.x + vNormal.y * vDelta.y + vNormal.z * vDelta.z) * fInvertedLength;
            fAO += std::max(0.0, fAngle) * std::max(0.0, fFalloff);
        }
    }
    return std::max(0.0, 1.0 - fAO / 16.0);
}

// "Upsample code": the bilinear factors as printed, for (x, y) = (0, 0), (1, 0), (0, 1), (1, 1).
inline std::array<double, 4> soma_listing_bilinear(SomaVec2 frag_coord) {
    const SomaVec2 vBilinearWeight = {1.0 - (frag_coord.x / 2.0 - std::floor(frag_coord.x / 2.0)),
                                      1.0 - (frag_coord.y / 2.0 - std::floor(frag_coord.y / 2.0))};
    std::array<double, 4> weights{};
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 2; ++x)
            weights[static_cast<size_t>(2 * y + x)] = (x - vBilinearWeight.x) * (y - vBilinearWeight.y);
    return weights;
}

inline double soma_listing_depth_weight(double fSampleDepth, double fMainDepth) {
    return std::max(0.00001, 0.1 - std::fabs(fSampleDepth - fMainDepth)) * 30.0;
}

// "Temporal blur code", from the fetched values on: the blended occlusion.
inline double soma_listing_temporal(double fAO, double fPrevFrameAO, SomaVec3 vPos, SomaVec3 vTemporalPos,
                                    double afFrameTime) {
    double fWeight = std::hypot(vTemporalPos.x - vPos.x, vTemporalPos.y - vPos.y, vTemporalPos.z - vPos.z) * 9.0;
    fWeight += std::fabs(fPrevFrameAO - fAO) * 5.0;
    fWeight = std::clamp(fWeight, afFrameTime, 1.0);
    return fPrevFrameAO + (fAO - fPrevFrameAO) * fWeight;
}

} // namespace sfumato::reference
