// Disturbances of an image: light, occlusion, blur, noise, compression, motion of the camera. Each
// function takes the severity and returns a function that applies the disturbance to 8-bit grey
// images. The result for one moment is always the same.
#pragma once

#include <functional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "tests/campaigns/robustness/moment.h"

namespace palpate::robustness {

using Paint = std::function<void(const View&, cv::Mat&)>;

// --- together
Paint All(std::vector<Paint> paints);  // one after the other
Paint OnSide(int side, Paint paint);   // of a pair: only there
Paint From(When when, Paint paint);

// --- light
Paint Flicker(double strength);  // of the whole image, +-`strength` [-] from image to image
Paint Vignette(double fall);     // `fall`: fraction by which the corners are darker [-]
Paint Gain(double factor);
Paint Gamma(double exponent);
// A soft-edged band, `depth` darker [-], across tool and object; it wanders over them.
Paint Shadow(double depth);
// Saturated discs of `radius` [px]: at the tool's tip, moving with it; on its shaft, `along` [px]
// from the tip, moving with it; where the shaft passes it at full depth, standing still.
Paint GlintOnTip(double radius);
Paint GlintOnShaft(double radius, double along);
Paint GlintStanding(double radius, double along);

// --- things in the way A straight wire of `width` [px] across the whole image at `degrees` from
// the image's x axis. It passes the tip's position at full depth at a distance of `off` [px] along
// the shaft.
Paint Wire(double width, double degrees, double off, double grey = 30);
// A plain patch that covers a fraction `share` of the tool's width along the whole shaft and moves
// with it.
Paint CoveredSide(double share);
// A plain patch across the shaft, from `from` to `to` [px] beyond the tip's place at full depth;
// it does not move.
Paint CoveredPiece(double from, double to);
// A large smooth blob that enters the image and stays. It extends `reach` [px] beyond the tip's
// position along the shaft; below 0 it ends before the tip.
Paint Hand(double reach, When when);
// Plain discs of `radius` [px] around places of the image [px].
Paint Patches(std::vector<Eigen::Vector2d> at_I, double radius, double grey = 200);

// --- blur, noise, compression
Paint Defocus(double sigma);                      // [px]
Paint MotionBlur(double length, double degrees);  // [px]
Paint Noise(double sigma);                        // [grey levels]
Paint Jpeg(int quality);                          // 1 to 100

// --- the camera moves
Paint Bump(const Eigen::Vector2d& by, When when);  // the image is shifted by `by` [px]
Paint Shake(double sigma);                         // per axis, drawn for each image [px]
Paint Drift(const Eigen::Vector2d& by);            // evenly, over the whole run [px]
Paint Zoom(double factor, When when);              // about the image's middle
Paint Turn(double degrees, When when);             // about the image's middle
// Barrel (or < 0 pincushion) distortion that is not in the scene: so far inwards in the corners
// [px].
Paint Barrel(double px);

}  // namespace palpate::robustness
