#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>

#include "shared/text/text.h"
#include "slave/tactile/network/network_file.h"
#include "slave/tactile/network/onnx_graph.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

constexpr int kOpenWindow = 50;
constexpr int kLargestWindow = 1000;
constexpr std::uintmax_t kLargestFile = 256u << 20;  // [bytes]

// OpenCV tells its troubles to stderr as well; what is thrown says them.
class Silence {
 public:
  Silence() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~Silence() { cv::utils::logging::setLogLevel(before_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

struct Model {
  std::vector<char> bytes;
  std::vector<int> shape;  // of the input, batch 1
  std::string output;
  int inputs = 0;
  int window = 1;
  int outputs = 0;
};

std::string InWords(const std::vector<long>& extents) {
  std::string words = "[";
  for (const long extent : extents) {
    if (words.size() > 1) words += ", ";
    words += extent > 0 ? std::to_string(extent) : "?";
  }
  return words + "]";
}

std::vector<char> ReadBytes(const fs::path& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  std::ifstream stream(file, std::ios::binary);
  if (error || !stream) throw std::runtime_error("cannot be read");
  if (size > kLargestFile) throw std::runtime_error("larger than 256 MB");
  return {std::istreambuf_iterator<char>(stream), {}};
}

void ReadShapes(const OnnxGraph& graph, Model* model) {
  if (graph.inputs.size() != 1) {
    throw std::runtime_error("it has " + std::to_string(graph.inputs.size()) +
                             " inputs, expected one");
  }
  const std::vector<long>& extents = graph.inputs[0].extents;
  const bool sequence = extents.size() == 3;
  const long window = !sequence ? 1 : extents[1] == 0 ? kOpenWindow : extents[1];
  const bool fits = (sequence || extents.size() == 2) && extents[0] <= 1 &&
                    (extents.back() == 19 || extents.back() == 21) && window <= kLargestWindow;
  if (!fits) {
    throw std::runtime_error("input " + graph.inputs[0].name + " is " + InWords(extents) +
                             ", expected [1, n] or [1, window, n] with n = 19 or 21 and a window " +
                             "of at most " + std::to_string(kLargestWindow));
  }
  if (graph.outputs.empty()) throw std::runtime_error("it has no output");
  model->output = graph.outputs[0].name;
  model->inputs = static_cast<int>(extents.back());
  model->window = static_cast<int>(window);
  model->shape = {1, model->inputs};
  if (sequence) model->shape = {1, model->window, model->inputs};
}

// The operator that OpenCV complains of, where it names one, and its reason: the innermost of
// `... error: REASON in function ...`.
std::string Complaint(const std::string& what, const OnnxGraph& graph) {
  std::string subject = "OpenCV cannot run it: ";
  for (const std::string& name : graph.operators) {
    const bool meant = what.find("[" + name + "@") != std::string::npos ||
                       what.find("of type \"" + name + "\"") != std::string::npos;
    if (meant) subject = "operator " + name + " is not supported by this OpenCV: ";
  }
  const std::size_t begin = what.rfind("error: ");
  if (begin == std::string::npos) return subject + what;
  const std::size_t end = what.find(" in function", begin);
  return subject + what.substr(begin + 7, end == std::string::npos ? end : end - begin - 7);
}

class OnnxEstimate final : public ForceEstimate {
 public:
  explicit OnnxEstimate(std::shared_ptr<const Model> model)
      : model_(std::move(model)),
        net_(cv::dnn::readNetFromONNX(model_->bytes.data(), model_->bytes.size())),
        input_(model_->shape, CV_32F, cv::Scalar(0)) {
    net_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  }

  // The outputs for what the input holds, one row. Throws cv::Exception.
  cv::Mat Forward() {
    net_.setInput(input_);
    return net_.forward(model_->output);
  }

  void Reset() noexcept override { seen_ = 0; }
  bool Push(const TactileSignals& change, std::span<double> outputs) noexcept override {
    const auto end = change.begin() + model_->inputs;
    if (!std::all_of(change.begin(), end, [](auto x) { return std::isfinite(x); })) {
      Reset();
      return false;
    }
    // The oldest sample comes first.
    const std::span<float> samples(input_.ptr<float>(), input_.total());
    const auto newest =
        std::rotate(samples.begin(), samples.begin() + model_->inputs, samples.end());
    std::copy(change.begin(), end, newest);
    seen_ = std::min(seen_ + 1, model_->window);
    return seen_ == model_->window && Evaluate(outputs);
  }

 private:
  bool Evaluate(std::span<double> outputs) noexcept {
    try {
      const cv::Mat row = Forward();
      if (row.total() != outputs.size() || row.type() != CV_32F) return false;
      const auto* numbers = row.ptr<float>();
      std::copy(numbers, numbers + outputs.size(), outputs.begin());
      return std::all_of(outputs.begin(), outputs.end(), [](double y) { return std::isfinite(y); });
    } catch (...) {
      return false;
    }
  }

  std::shared_ptr<const Model> model_;
  cv::dnn::Net net_;
  cv::Mat input_;
  int seen_ = 0;
};

// Runs the model once on an untouched fingertip.
int CountOutputs(const std::shared_ptr<const Model>& model) {
  const cv::Mat row = OnnxEstimate(model).Forward();
  std::vector<long> extents(row.size.p, row.size.p + row.dims);
  const auto total = static_cast<long>(row.total());
  if (row.type() != CV_32F || extents.empty() || extents.back() != total || total < 3) {
    throw std::runtime_error("output " + model->output + " is " + InWords(extents) +
                             ", expected one row of 3 or more (fx, fy, fz first)");
  }
  if (!cv::checkRange(row)) throw std::runtime_error("its outputs at rest are not finite");
  return static_cast<int>(total);
}

class OnnxNetwork final : public ForceNetwork {
 public:
  OnnxNetwork(std::shared_ptr<const Model> model, std::string origin) : model_(std::move(model)) {
    info_.architecture = "onnx";
    info_.inputs = model_->inputs;
    info_.window = model_->window;
    info_.outputs = model_->outputs;
    info_.origin = std::move(origin);
  }

  [[nodiscard]] const NetworkInfo& info() const override { return info_; }
  [[nodiscard]] std::unique_ptr<ForceEstimate> Windowed() const override {
    const Silence silence;
    return std::make_unique<OnnxEstimate>(model_);
  }
  [[nodiscard]] std::unique_ptr<ForceEstimate> CarryingState() const override { return Windowed(); }

 private:
  NetworkInfo info_;
  std::shared_ptr<const Model> model_;
};

std::shared_ptr<const Model> ReadModel(const fs::path& file) {
  Model model;
  model.bytes = ReadBytes(file);
  const OnnxGraph graph = ReadOnnxGraph({model.bytes.data(), model.bytes.size()});
  ReadShapes(graph, &model);
  try {
    const Silence silence;
    model.outputs = CountOutputs(std::make_shared<Model>(model));
  } catch (const cv::Exception& error) {
    throw std::runtime_error(Complaint(error.what(), graph));
  }
  return std::make_shared<Model>(std::move(model));
}

}  // namespace

std::unique_ptr<ForceNetwork> LoadOnnxNetwork(const fs::path& file) {
  return NamingFile(file, [&]() -> std::unique_ptr<ForceNetwork> {
    return std::make_unique<OnnxNetwork>(ReadModel(file), "ONNX model " + file.filename().string());
  });
}

}  // namespace palpate
