#include "slave/tactile/training/dense_gradient.h"

#include <random>
#include <utility>

#include "slave/tactile/training/initial_weights.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::MatrixXf;
using Eigen::VectorXf;

constexpr int kOutputs = 3;

class DenseGradient final : public BatchGradient {
 public:
  DenseGradient(int inputs, const std::vector<int>& hidden) : inputs_(inputs) {
    Index from = inputs;
    for (const int units : hidden) {
      layers_.push_back({from, units});
      from = units;
    }
    layers_.push_back({from, kOutputs});
    for (Layer& layer : layers_) {
      layer.at = weight_count_;
      weight_count_ += (layer.inputs + 1) * layer.outputs;
    }
  }

  [[nodiscard]] int steps() const override { return 1; }
  [[nodiscard]] int inputs() const override { return inputs_; }
  [[nodiscard]] Index weight_count() const override { return weight_count_; }

  [[nodiscard]] VectorXf Initial(std::uint64_t seed) const override {
    VectorXf weights = VectorXf::Zero(weight_count_);
    std::mt19937_64 random(seed);
    for (const Layer& layer : layers_) {
      SpreadUniformly(layer.inputs, layer.outputs, &random, weights.data() + layer.at);
    }
    return weights;
  }

  const MatrixXf& Forward(const VectorXf& weights, Batch batch) override {
    input_ = batch.front();
    const MatrixXf* x = &input_;
    for (Layer& layer : layers_) {
      const Eigen::Map<const MatrixXf> W(weights.data() + layer.at, layer.inputs, layer.outputs);
      const Eigen::Map<const Eigen::RowVectorXf> b(W.data() + W.size(), layer.outputs);
      layer.y.noalias() = *x * W;
      layer.y.rowwise() += b;
      if (&layer != &layers_.back()) layer.y = layer.y.array().tanh();
      x = &layer.y;
    }
    return layers_.back().y;
  }

  void Backward(const VectorXf& weights, const MatrixXf& d_outputs, VectorXf* gradient) override {
    MatrixXf d_y = d_outputs;
    for (std::size_t k = layers_.size(); k-- > 0;) {
      const Layer& layer = layers_[k];
      const MatrixXf& x = k == 0 ? input_ : layers_[k - 1].y;
      const Eigen::Map<const MatrixXf> W(weights.data() + layer.at, layer.inputs, layer.outputs);
      Eigen::Map<MatrixXf> d_W(gradient->data() + layer.at, layer.inputs, layer.outputs);
      Eigen::Map<Eigen::RowVectorXf> d_b(d_W.data() + d_W.size(), layer.outputs);
      d_W.noalias() += x.transpose() * d_y;
      d_b += d_y.colwise().sum();
      if (k == 0) break;
      d_y = (d_y * W.transpose()).cwiseProduct((1 - x.array().square()).matrix()).eval();
    }
  }

  void FillLayers(const VectorXf& weights, NetworkWeights* network) const override {
    network->lstm.clear();
    network->dense.clear();
    network->activation = HiddenActivation::kTanh;
    for (const Layer& layer : layers_) {
      const Eigen::Map<const MatrixXf> W(weights.data() + layer.at, layer.inputs, layer.outputs);
      network->dense.push_back({W, Eigen::Map<const VectorXf>(W.data() + W.size(), layer.outputs)});
    }
  }

 private:
  struct Layer {
    Index inputs, outputs;
    Index at = 0;  // of its first weight
    MatrixXf y{};  // batch x outputs
  };
  int inputs_;
  Index weight_count_ = 0;
  std::vector<Layer> layers_;
  MatrixXf input_;
};

}  // namespace

std::unique_ptr<BatchGradient> MakeDenseGradient(int inputs, const std::vector<int>& hidden) {
  return std::make_unique<DenseGradient>(inputs, hidden);
}

}  // namespace palpate
