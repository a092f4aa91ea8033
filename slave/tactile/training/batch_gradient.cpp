#include "slave/tactile/training/batch_gradient.h"

#include <cmath>
#include <random>

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::MatrixXf;
using Eigen::VectorXf;

constexpr int kOutputs = 3;

// Fills a matrix of `inputs` x `outputs` at `weights` with numbers drawn uniformly from
// +-sqrt(6 / (inputs + outputs)), which keeps signals and gradients at their size from layer to
// layer (Glorot and Bengio 2010). Drawn from the generator's bits, so that every library gives the
// same numbers.
void SpreadUniformly(Eigen::Index inputs, Eigen::Index outputs, std::mt19937_64* random,
                     float* weights) {
  const double bound = std::sqrt(6.0 / static_cast<double>(inputs + outputs));
  for (Eigen::Index i = 0; i < inputs * outputs; ++i) {
    const double unit = static_cast<double>((*random)() >> 11) * 0x1p-53;  // 0 to 1
    weights[i] = static_cast<float>(bound * (2 * unit - 1));
  }
}

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

enum Gate : int { kI, kJ, kF, kO };

// The columns of one gate.
template <typename Matrix>
auto Block(Matrix& gates, Gate gate) {
  const Index units = gates.cols() / 4;
  return gates.middleCols(gate * units, units);
}

// One layer over a batch, every step kept. The batch is the fast axis of every matrix.
class LstmLayerGradient {
 public:
  LstmLayerGradient(int inputs, int hidden, int steps)
      : inputs_(inputs), hidden_(hidden), steps_(static_cast<std::size_t>(steps)) {}

  [[nodiscard]] Index weight_count() const { return (inputs_ + hidden_ + 1) * 4 * hidden_; }
  [[nodiscard]] std::size_t step_count() const { return steps_.size(); }
  // What the layer reads at `step`: batch x inputs, to be filled before Forward.
  auto Input(std::size_t step) { return steps_[step].xh.leftCols(inputs_); }
  [[nodiscard]] const MatrixXf& output(std::size_t step) const { return steps_[step].h; }
  // Gradient with respect to what was read, batch x inputs, after Backward of that step.
  [[nodiscard]] auto d_input() const { return d_xh_.leftCols(inputs_); }

  void Resize(Index batch) {
    if (!steps_.empty() && steps_.front().xh.rows() == batch) return;
    for (Step& s : steps_) {
      s.xh.resize(batch, inputs_ + hidden_);
      s.gates.resize(batch, 4 * hidden_);
      s.c.resize(batch, hidden_);
      s.tanh_c.resize(batch, hidden_);
      s.h.resize(batch, hidden_);
    }
    d_z_.resize(batch, 4 * hidden_);
    d_xh_.resize(batch, inputs_ + hidden_);
    d_c_.resize(batch, hidden_);
  }

  void Forward(const float* weights, std::size_t step) {
    const Eigen::Map<const MatrixXf> kernel(weights, inputs_ + hidden_, 4 * hidden_);
    const Eigen::Map<const Eigen::RowVectorXf> bias(weights + kernel.size(), 4 * hidden_);
    Step& s = steps_[step];
    if (step == 0) {
      s.xh.rightCols(hidden_).setZero();
    } else {
      s.xh.rightCols(hidden_) = steps_[step - 1].h;
    }
    s.gates.noalias() = s.xh * kernel;
    s.gates.rowwise() += bias;
    Block(s.gates, kI) = Block(s.gates, kI).array().logistic();
    Block(s.gates, kJ) = Block(s.gates, kJ).array().tanh();
    Block(s.gates, kF) = (Block(s.gates, kF).array() + kForgetBias).logistic();
    Block(s.gates, kO) = Block(s.gates, kO).array().logistic();
    s.c = Block(s.gates, kI).cwiseProduct(Block(s.gates, kJ));
    if (step > 0) s.c += Block(s.gates, kF).cwiseProduct(steps_[step - 1].c);
    s.tanh_c = s.c.array().tanh();
    s.h = s.tanh_c.cwiseProduct(Block(s.gates, kO));
  }

  [[nodiscard]] LstmLayer Layer(const float* weights) const {
    const Eigen::Map<const MatrixXf> kernel(weights, inputs_ + hidden_, 4 * hidden_);
    return {kernel, Eigen::Map<const VectorXf>(weights + kernel.size(), 4 * hidden_)};
  }

  // `d_h`: the gradient with respect to this step's output from above; what comes from the next
  // step is added. Steps in descending order, all of them.
  void Backward(const float* weights, std::size_t step, const MatrixXf* d_h, float* gradient) {
    const Step& s = steps_[step];
    if (step + 1 == steps_.size()) {
      d_xh_.setZero();
      d_c_.setZero();
    }
    if (d_h != nullptr) d_xh_.rightCols(hidden_) += *d_h;
    const auto d_out = d_xh_.rightCols(hidden_).array();
    const auto i = Block(s.gates, kI).array(), j = Block(s.gates, kJ).array(),
               f = Block(s.gates, kF).array(), o = Block(s.gates, kO).array();
    d_c_.array() += d_out * o * (1 - s.tanh_c.array().square());
    Block(d_z_, kO) = d_out * s.tanh_c.array() * o * (1 - o);
    Block(d_z_, kI) = d_c_.array() * j * i * (1 - i);
    Block(d_z_, kJ) = d_c_.array() * i * (1 - j.square());
    if (step > 0) {
      Block(d_z_, kF) = d_c_.array() * steps_[step - 1].c.array() * f * (1 - f);
      d_c_.array() *= f;
    } else {
      Block(d_z_, kF).setZero();
    }
    const Eigen::Map<const MatrixXf> kernel(weights, inputs_ + hidden_, 4 * hidden_);
    Eigen::Map<MatrixXf> d_kernel(gradient, inputs_ + hidden_, 4 * hidden_);
    Eigen::Map<Eigen::RowVectorXf> d_bias(gradient + d_kernel.size(), 4 * hidden_);
    d_kernel.noalias() += s.xh.transpose() * d_z_;
    d_bias += d_z_.colwise().sum();
    d_xh_.noalias() = d_z_ * kernel.transpose();
  }

 private:
  struct Step {
    MatrixXf xh;     // batch x (inputs + hidden): what is read and the state before
    MatrixXf gates;  // batch x 4 hidden, after their sigmoid or tanh
    MatrixXf c, tanh_c, h;
  };

  Index inputs_, hidden_;
  std::vector<Step> steps_;
  MatrixXf d_z_, d_xh_, d_c_;
};

class LstmGradient final : public BatchGradient {
 public:
  LstmGradient(int inputs, int hidden, int steps)
      : inputs_(inputs),
        hidden_(hidden),
        first_(inputs, hidden, steps),
        second_(hidden, hidden, steps) {}

  [[nodiscard]] int steps() const override { return static_cast<int>(first_.step_count()); }
  [[nodiscard]] int inputs() const override { return inputs_; }
  [[nodiscard]] Index weight_count() const override {
    return OutputAt() + (hidden_ + 1) * kOutputs;
  }

  [[nodiscard]] VectorXf Initial(std::uint64_t seed) const override {
    VectorXf weights = VectorXf::Zero(weight_count());
    std::mt19937_64 random(seed);
    SpreadUniformly(inputs_ + hidden_, 4 * hidden_, &random, weights.data());
    SpreadUniformly(2 * hidden_, 4 * hidden_, &random, weights.data() + first_.weight_count());
    SpreadUniformly(hidden_, kOutputs, &random, weights.data() + OutputAt());
    return weights;
  }

  const MatrixXf& Forward(const VectorXf& weights, Batch batch) override {
    const Index rows = batch.front().rows();
    first_.Resize(rows);
    second_.Resize(rows);
    for (std::size_t t = 0; t < batch.size(); ++t) {
      first_.Input(t) = batch[t];
      first_.Forward(weights.data(), t);
      second_.Input(t) = first_.output(t);
      second_.Forward(weights.data() + first_.weight_count(), t);
    }
    const Eigen::Map<const MatrixXf> W(weights.data() + OutputAt(), hidden_, kOutputs);
    const Eigen::Map<const Eigen::RowVectorXf> b(W.data() + W.size(), kOutputs);
    outputs_.noalias() = second_.output(batch.size() - 1) * W;
    outputs_.rowwise() += b;
    return outputs_;
  }

  void Backward(const VectorXf& weights, const MatrixXf& d_outputs, VectorXf* gradient) override {
    const Eigen::Map<const MatrixXf> W(weights.data() + OutputAt(), hidden_, kOutputs);
    Eigen::Map<MatrixXf> d_W(gradient->data() + OutputAt(), hidden_, kOutputs);
    Eigen::Map<Eigen::RowVectorXf> d_b(d_W.data() + d_W.size(), kOutputs);
    const std::size_t last = first_.step_count() - 1;
    d_W.noalias() += second_.output(last).transpose() * d_outputs;
    d_b += d_outputs.colwise().sum();
    d_h2_.noalias() = d_outputs * W.transpose();
    for (std::size_t t = last + 1; t-- > 0;) {
      second_.Backward(weights.data() + first_.weight_count(), t, t == last ? &d_h2_ : nullptr,
                       gradient->data() + first_.weight_count());
      d_h1_ = second_.d_input();
      first_.Backward(weights.data(), t, &d_h1_, gradient->data());
    }
  }

  void FillLayers(const VectorXf& weights, NetworkWeights* network) const override {
    const Eigen::Map<const MatrixXf> W(weights.data() + OutputAt(), hidden_, kOutputs);
    network->lstm = {first_.Layer(weights.data()),
                     second_.Layer(weights.data() + first_.weight_count())};
    network->dense = {{W, Eigen::Map<const VectorXf>(W.data() + W.size(), kOutputs)}};
  }

 private:
  [[nodiscard]] Index OutputAt() const { return first_.weight_count() + second_.weight_count(); }

  int inputs_, hidden_;
  LstmLayerGradient first_, second_;
  MatrixXf outputs_, d_h1_, d_h2_;
};

}  // namespace

std::unique_ptr<BatchGradient> MakeDenseGradient(int inputs, const std::vector<int>& hidden) {
  return std::make_unique<DenseGradient>(inputs, hidden);
}

std::unique_ptr<BatchGradient> MakeLstmGradient(int inputs, int hidden, int steps) {
  return std::make_unique<LstmGradient>(inputs, hidden, steps);
}

}  // namespace palpate
