// Limits of one camera's checks. Rows in the evidence are those of the robustness suite.
#pragma once

namespace palpate {

struct CameraLimits {
  // First image against the scene.
  // Error of the object's size [-].
  static constexpr double kMaxScale = 0.02;
  // Residual of the object's outline, rms [px].
  static constexpr double kMaxResidual = 2;
  // Distance of the tool's end from the encoder reading [px]. [tuned: the arm's report wrong]
  static constexpr double kToolElsewhere = 1;
  // Error of the tool's width [-]. [tuned: tool's width stated wrong]
  static constexpr double kToolWidth = 0.12;
  // Smallest sharpness of the edge, 1: sharp [-].
  static constexpr double kSharpAtRest = 0.30;

  // Each image.
  // Smallest sharpness relative to the first image [-]. [tuned: defocus while pressed]
  static constexpr double kSharpness = 0.47;
  // Brightest edge, of the largest grey level [-]. [tuned: over-exposed at rest]
  static constexpr double kOverexposed = 1.15;
  // Noise of a real camera [1/255 of full scale].
  static constexpr double kMinNoise = 0.5;
  // Images in which less noise is found, and share of the image that it changes: the tool moves in
  // a smaller one. [by definition]
  static constexpr int kLearning = 30;
  static constexpr double kNoisyShare = 0.9;
  // Smallest sigma of a tip that is only roughly known: in pixels, and relative to the indentation
  // [-].
  static constexpr double kRoughTip = 0.4, kRough = 0.12;
  // Motion of the image [px]. [tuned: camera bumped while pressed]
  static constexpr double kMaxShift = 40;
  // Turn of the image [rad], and its growth [-].
  static constexpr double kMaxTurn = 0.06, kMaxGrowth = 0.03;
  // Indentation that needs no confirmation [px].
  static constexpr double kSmallIndentation = 1.5;
  // Number of images in which a larger one may stay unseen [-].
  static constexpr int kUnconfirmed = 6;
  // Sigma of the edge's indentation without any model error, per axis [px].
  static constexpr double kEdgeSigma = 0.2;
  // Square of the whitened difference from which on indentations disagree [-]: 3.5 sigma. [tuned:
  // wire over the shaft at 0 deg]
  static constexpr double kIndentationGate = 12.25;
  // Number of images that must agree before an indentation is trusted again [images]. [tuned:
  // APressWithoutItsIndentationIsNotValid]
  static constexpr int kDistrust = 3;
  // Consecutive edge positions beside the outline: more is an occlusion [-].
  static constexpr int kMaxApart = 7;
};

}  // namespace palpate
