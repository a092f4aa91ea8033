// Faults of lens, sensor, shutter and link other than light and blur, and objects that enter the
// view. Uses the `Paint` of paint.h.
#pragma once

#include <functional>

#include <opencv2/core/mat.hpp>

#include "tests/campaigns/robustness/moment.h"
#include "tests/campaigns/robustness/paint.h"

namespace palpate::robustness {

// --- on the lens
// A soft patch of 45 px over the tip's place at full depth: blurred by `blur` [px], its contrast
// lower by `veil` [-].
Paint Smudge(double blur, double veil);
Paint Dust(int count);  // dark specks of 2 to 5 px all over the image, standing still
// Zoom about the image's centre that grows over the run to `factor`.
Paint Breathing(double factor);
Paint TurnSlowly(double degrees);
Paint LoseFocus(double sigma);  // growing over the run [px]
Paint Haze(double veil);        // contrast lower, towards white, growing over the run [-]
// Haze in the half of the image beside the tip's position at full depth.
Paint Fog(double veil);
// A drop of 40 px radius beside the tip's position at full depth. It displaces the image within it
// outwards by up to `pull` [px].
Paint Droplet(double pull);
// A reflection in glass: a second image, shifted by 14 px, of this intensity [-].
Paint Ghost(double share);
Paint HeatHaze(double sigma);  // parts are shifted differently in each image [px]

// --- in the sensor
Paint Wobble(double px);  // shifts each row by a moving wave with a length of 120 rows
Paint Comb(double px);    // shifts every other row
Paint DeadRows(int count, double level);  // rows through the tip's position at full depth
Paint DeadColumns(int count, double level);
Paint HotPixels(double share);
Paint Banding(double strength);      // bands of 40 rows lighter and darker, wandering
Paint Quantised(int levels);         // reduces the image to this number of grey levels
Paint RollingGain(double strength);  // one bright and one dark half, wandering down
// The `count` rows below the tip's position at full depth repeat the row there.
Paint StuckRows(int count);
Paint DeadClusters(int count);  // black, of 3 to 7 px, all over the image
Paint Moire(double levels);     // waves of 2.7 px and of 31 px multiplied, standing
Paint Inverted();

// --- light
Paint OneSided(double strength);  // lighter by `strength` at one side, darker at the other

// --- on the line
enum class Part { kUpper, kLower };
Paint PartlyGrey(Part part, double share);
// Masks of pixels that keep the content of the first image: a fraction `share` of the image of
// camera `side` (below 0: of both cameras), or the same fraction of its blocks of 16 px.
using Mask = std::function<void(const Moment&, cv::Mat&)>;
Mask PartlyOld(Part part, double share, int side = -1);
Mask BlocksLost(double share);
Paint Mirrored(int flip_code);  // cv::flip's
Paint Resized(double factor);

// --- in view
Paint SecondTool(double aside);  // a second image of the tool, shifted sideways by this [px]
// A plain square at this distance from the tip's position at full depth [px].
Paint Neighbour(double beside);
Paint Rain(int count);           // bright streaks of 30 px at new places in each image
Paint Insect(double size);       // dark, with legs; crawls over tool and object
Paint MovingWire(double width);  // crosses the shaft and the object from one side to the other

}  // namespace palpate::robustness
