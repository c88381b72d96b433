// The network on libtorch: the whole of the module orasp_torch.so, and the only file that includes
// libtorch (18 s to compile). One function is found by name: orasp_make_network_1. It uses headers
// of the library, none of its code.

#include "orasp/learning/network.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <type_traits>
#include <utility>

#include <ATen/Parallel.h>
#include <torch/cuda.h>
#include <torch/nn/functional/loss.h>
#include <torch/nn/modules/container/modulelist.h>
#include <torch/nn/modules/linear.h>
#include <torch/nn/utils/clip_grad.h>
#include <torch/optim/adamw.h>

#include "orasp/learning/detail/optimiser_key.h"
#include "orasp/model/error.h"

namespace orasp {

namespace {

using torch::Tensor;

/// Linear layers with ReLU between them.
struct Layers {
  std::vector<torch::nn::Linear> linear;

  explicit Layers(const NetworkOptions& options) {
    std::size_t inputs = options.connections;
    const auto add = [&](std::size_t outputs) {
      linear.emplace_back(torch::nn::LinearOptions(static_cast<std::int64_t>(inputs),
                                                   static_cast<std::int64_t>(outputs)));
      inputs = outputs;
    };
    for (const std::size_t units : options.hidden) add(units);
    add(options.outputs != 0 ? options.outputs : options.connections);
    if (options.zero_outputs) {
      const torch::NoGradGuard no_gradient;
      linear.back()->weight.zero_();
      linear.back()->bias.zero_();
    }
  }
  void to(const torch::Device& device) {
    for (auto& layer : linear) layer->to(device);
  }
  [[nodiscard]] Tensor forward(Tensor x) const {
    for (std::size_t l = 0; l < linear.size(); ++l) {
      x = at::linear(x, linear[l]->weight, linear[l]->bias);
      if (l + 1 < linear.size()) x = x.relu_();
    }
    return x;
  }
  [[nodiscard]] std::vector<Tensor> parameters() const {
    std::vector<Tensor> all;
    for (const auto& layer : linear) {
      all.push_back(layer->weight);
      all.push_back(layer->bias);
    }
    return all;
  }
};

torch::Device device_called(const std::string& name) {
  if (name == "cpu") return torch::kCPU;
  const bool has_cuda = torch::cuda::is_available();
  if (name == "auto") return has_cuda ? torch::kCUDA : torch::kCPU;
  if (name != "cuda") throw InputError("device '" + name + "' is none of auto, cpu, cuda");
  if (!has_cuda) {
    throw InputError(
        "device 'cuda' is not there: this libtorch sees no GPU (Debian's is built without CUDA; "
        "docs/learning.md says how to build against another)");
  }
  return torch::kCUDA;
}

/// The machine's linear algebra, by what is mapped into the process.
bool has_openblas() {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    if (line.find("openblas") != std::string::npos || line.find("mkl") != std::string::npos)
      return true;
  }
  return false;
}

class TorchNetwork final : public Network {
 public:
  explicit TorchNetwork(const NetworkOptions& options)
      : options_(options),
        device_(device_called(options.device)),
        online_(seeded(options)),
        target_(options),
        optimiser_(
            moved(online_, device_),
            torch::optim::AdamWOptions(options.learning_rate).amsgrad(true).weight_decay(0.01)) {
    target_.to(device_);
    for (Tensor& parameter : targets()) parameter.requires_grad_(false);
    follow(1);
  }

  void values(std::span<const float> states, std::span<float> values) override {
    run(online_, states, values);
  }
  void target_values(std::span<const float> states, std::span<float> values) override {
    run(target_, states, values);
  }

  double learn(std::span<const float> states, std::span<const std::int64_t> actions,
               std::span<const float> targets) override {
    const auto batch = static_cast<std::int64_t>(actions.size());
    const Tensor in = on_device(states, {batch, width()});
    const Tensor taken =
        torch::from_blob(const_cast<std::int64_t*>(actions.data()), {batch, 1}, torch::kInt64)
            .to(device_);
    const Tensor wanted = on_device(targets, {batch, 1});
    const Tensor loss = torch::smooth_l1_loss(online_.forward(in).gather(1, taken), wanted);
    optimiser_.zero_grad();
    loss.backward();
    torch::nn::utils::clip_grad_value_(online_.parameters(), options_.gradient_clip);
    optimiser_.step();
    follow(options_.target_rate);
    return loss.item<double>();
  }

  [[nodiscard]] std::vector<DenseLayer> layers() const override {
    std::vector<DenseLayer> plain;
    for (const auto& linear : online_.linear) {
      DenseLayer layer;
      layer.outputs = static_cast<std::size_t>(linear->weight.size(0));
      layer.inputs = static_cast<std::size_t>(linear->weight.size(1));
      append(linear->weight.detach().t(), layer.weights);
      append(linear->bias.detach(), layer.bias);
      plain.push_back(std::move(layer));
    }
    return plain;
  }

  [[nodiscard]] std::vector<float> state() const override {
    std::vector<float> all;
    for (const Tensor& tensor : tensors()) append(tensor, all);
    all.push_back(static_cast<float>(steps()));
    return all;
  }

  void restore(std::span<const float> state) override {
    const torch::NoGradGuard no_gradient;
    make_moments();
    std::size_t at = 0;
    for (Tensor& tensor : tensors()) {
      const auto size = static_cast<std::size_t>(tensor.numel());
      if (size > state.size() - at) throw wrong_shape();
      tensor.copy_(torch::from_blob(const_cast<float*>(state.data() + at), tensor.sizes()));
      at += size;
    }
    if (at + 1 != state.size()) throw wrong_shape();
    for (const Tensor& parameter : online_.parameters())
      moments_of(parameter).step(static_cast<std::int64_t>(state[at]));
  }

  [[nodiscard]] std::string device() const override { return device_.is_cuda() ? "cuda" : "cpu"; }

  [[nodiscard]] std::string warning() const override {
    if (device_.is_cuda() || has_openblas()) return {};
    return "libtorch computes with the reference BLAS, ten times slower than it could: install "
           "the package libopenblas0-pthread";
  }

 private:
  using Moments = torch::optim::AdamWParamState;

  static Layers seeded(const NetworkOptions& options) {
    torch::manual_seed(options.seed);
    return Layers(options);
  }
  static std::vector<Tensor> moved(Layers& layers, const torch::Device& device) {
    layers.to(device);
    return layers.parameters();
  }
  static InputError wrong_shape() {
    return InputError("the training state is of a network of another shape");
  }
  [[nodiscard]] std::int64_t width() const {
    return static_cast<std::int64_t>(options_.connections);
  }
  [[nodiscard]] Tensor on_device(std::span<const float> numbers, at::IntArrayRef shape) const {
    return torch::from_blob(const_cast<float*>(numbers.data()), shape).to(device_);
  }
  void run(const Layers& network, std::span<const float> states, std::span<float> values) const {
    const torch::InferenceMode inference;
    const auto batch = static_cast<std::int64_t>(states.size() / options_.connections);
    torch::from_blob(values.data(), {batch, static_cast<std::int64_t>(values.size()) / batch})
        .copy_(network.forward(on_device(states, {batch, width()})));
  }
  static void append(const Tensor& tensor, std::vector<float>& numbers) {
    const Tensor plain = tensor.detach().to(torch::kCPU).contiguous();
    numbers.insert(numbers.end(), plain.data_ptr<float>(), plain.data_ptr<float>() + plain.numel());
  }
  [[nodiscard]] std::vector<Tensor> targets() const { return target_.parameters(); }

  /// The target network moves towards the network.
  void follow(double rate) {
    const torch::NoGradGuard no_gradient;
    const std::vector<Tensor> from = online_.parameters();
    std::vector<Tensor> to = targets();
    for (std::size_t i = 0; i < to.size(); ++i) to[i].lerp_(from[i], rate);
  }

  // The optimiser makes its moments at its first step.
  using Key = std::remove_cvref_t<decltype(std::declval<torch::optim::AdamW&>().state())>::key_type;
  [[nodiscard]] static Key key(const Tensor& parameter) {
    return detail::optimiser_key<Key>(parameter.unsafeGetTensorImpl(),
                                      [](auto* tensor) { return c10::guts::to_string(tensor); });
  }
  void make_moments() {
    for (const Tensor& parameter : online_.parameters()) {
      auto& known = optimiser_.state();
      if (known.find(key(parameter)) != known.end()) continue;
      auto moments = std::make_unique<Moments>();
      moments->step(0);
      moments->exp_avg(torch::zeros_like(parameter.detach()));
      moments->exp_avg_sq(torch::zeros_like(parameter.detach()));
      moments->max_exp_avg_sq(torch::zeros_like(parameter.detach()));
      known[key(parameter)] = std::move(moments);
    }
  }
  [[nodiscard]] Moments& moments_of(const Tensor& parameter) const {
    return static_cast<Moments&>(*optimiser_.state().at(key(parameter)));
  }
  [[nodiscard]] bool has_moments() const { return !optimiser_.state().empty(); }
  [[nodiscard]] std::int64_t steps() const {
    return has_moments() ? moments_of(online_.linear.front()->weight).step() : 0;
  }
  /// Every tensor of the training state, in its order.
  [[nodiscard]] std::vector<Tensor> tensors() const {
    std::vector<Tensor> all = online_.parameters();
    for (Tensor& parameter : all) parameter = parameter.detach();  // the same memory
    for (const Tensor& parameter : targets()) all.push_back(parameter);
    for (const Tensor& parameter : online_.parameters()) {
      if (has_moments()) {
        const Moments& moments = moments_of(parameter);
        for (const Tensor& moment :
             {moments.exp_avg(), moments.exp_avg_sq(), moments.max_exp_avg_sq()})
          all.push_back(moment);
      } else {
        all.insert(all.end(), 3, torch::zeros_like(parameter.detach()));
      }
    }
    return all;
  }

  NetworkOptions options_;
  torch::Device device_;
  Layers online_;
  Layers target_;
  mutable torch::optim::AdamW optimiser_;
};

/// More threads are slower at these sizes, and much slower on a busy machine.
void use_one_thread() {
  static const bool done = [] {
    at::set_num_threads(1);
    at::set_num_interop_threads(1);
    return true;
  }();
  static_cast<void>(done);
}

}  // namespace

}  // namespace orasp

extern "C" __attribute__((visibility("default"))) orasp::Network* orasp_make_network_1(
    const orasp::NetworkOptions& options) {
  orasp::use_one_thread();
  return new orasp::TorchNetwork(options);
}
