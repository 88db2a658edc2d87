#include <algorithm>
#include <optional>
#include <utility>

#include <openvino/frontend/manager.hpp>
#include <openvino/openvino.hpp>

#include "extperfc/base/text.hpp"

#include "detect/backends.hpp"

namespace extperfc::detect {

namespace {

/// One for the process: it holds the loaded device plug-ins.
ov::Core& core() {
  static ov::Core instance;
  return instance;
}

std::string plural(int count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

ov::element::Type element_type(Precision precision) {
  switch (precision) {
    case Precision::kF16:
      return ov::element::f16;
    case Precision::kBf16:
      return ov::element::bf16;
    case Precision::kF32:
      break;
  }
  return ov::element::f32;
}

/// A property of a compiled model; empty when its device has no such property.
template <typename T, ov::PropertyMutability mutability>
std::optional<T> property_of(const ov::CompiledModel& model, const ov::Property<T, mutability>& property) {
  try {
    return model.get_property(property);
  } catch (const ov::Exception&) {
    return std::nullopt;
  }
}

/// A network compiled by OpenVINO, for any of its devices. In throughput mode it has as many slots as the
/// device can keep busy.
class OpenVinoBackend : public InferenceBackend {
 public:
  OpenVinoBackend(ov::CompiledModel model, std::vector<std::string> outputs, int slot_count)
      : model_(std::move(model)), output_names_(std::move(outputs)) {
    for (int i = 0; i < slot_count; ++i) requests_.push_back(model_.create_infer_request());
  }

  std::string name() const override { return "openvino"; }
  std::string execution() const override;
  int slots() const override { return static_cast<int>(requests_.size()); }
  float* input(int slot) override { return request(slot).get_input_tensor().data<float>(); }

  Result<std::vector<TensorView>> infer(int slot) override try {
    request(slot).infer();
    std::vector<TensorView> views;
    for (const auto& name : output_names_) {
      const ov::Tensor tensor = request(slot).get_tensor(name);
      const ov::Shape& shape = tensor.get_shape();
      views.push_back({{shape.begin(), shape.end()}, tensor.data<const float>()});
    }
    return views;
  } catch (const std::exception& error) {
    return fail(ErrorCode::kFailed, "inference: " + shortened(error.what()));
  }

 private:
  ov::InferRequest& request(int slot) { return requests_[static_cast<std::size_t>(slot)]; }

  ov::CompiledModel model_;
  std::vector<std::string> output_names_;
  std::vector<ov::InferRequest> requests_;
};

std::string OpenVinoBackend::execution() const {
  std::string text = joined(property_of(model_, ov::execution_devices).value_or(std::vector<std::string>{}));
  if (const auto type = property_of(model_, ov::hint::inference_precision)) text += " " + type->to_string();
  if (const auto streams = property_of(model_, ov::num_streams))
    text += ", " + plural(streams->num, "stream");
  if (const auto threads = property_of(model_, ov::inference_num_threads))
    text += ", " + plural(*threads, "thread");
  return text;
}

/// "GPU" matches GPU, GPU.0 and GPU.1; AUTO is always there.
Result<void> check_device(const std::string& device) {
  const auto existing = core().get_available_devices();
  const bool found = std::any_of(existing.begin(), existing.end(), [&device](const std::string& name) {
    return name == device || name.rfind(device + ".", 0) == 0;
  });
  if (found || device == "AUTO") return {};
  return fail(ErrorCode::kUnsupported, "this machine has no device " + device +
                                           " that OpenVINO can use, only " + enumeration(existing) +
                                           ": set device to one of these or AUTO");
}

/// All names of all ports; a port may have several.
template <typename Ports>
std::vector<std::string> names_of(const Ports& ports) {
  std::vector<std::string> names;
  for (const auto& port : ports) {
    const auto& of_port = port.get_names();
    names.insert(names.end(), of_port.begin(), of_port.end());
  }
  return names;
}

Result<void> check_input(const ov::Model& model, const InputSpec& input) {
  const auto names = names_of(model.inputs());
  if (model.inputs().size() != 1)
    return fail(ErrorCode::kUnsupported,
                "the network has the inputs " + enumeration(names) + ", but only one input can be fed");
  if (input.name.empty() || std::find(names.begin(), names.end(), input.name) != names.end()) return {};
  return fail(ErrorCode::kInvalidArgument, "the network has no input \"" + input.name + "\", only " +
                                               enumeration(names) + ": correct input.name in model.yaml");
}

/// Fixes the input to [1, 3, height, width], which a network without fixed sizes inside allows.
Result<void> fix_shape(ov::Model& model, const InputSpec& input) {
  const ov::PartialShape wanted{1, 3, input.height, input.width};
  const std::string actual = model.input().get_partial_shape().to_string();
  try {
    if (model.input().get_partial_shape() != wanted) model.reshape(wanted);
  } catch (const std::exception&) {
    return fail(ErrorCode::kInvalidArgument, "the network's input is " + actual + " and cannot be made " +
                                                 wanted.to_string() +
                                                 ": correct input.width and input.height in model.yaml");
  }
  return {};
}

/// Float32 at both ends, independent of the network's precision.
std::shared_ptr<ov::Model> with_float_ends(const std::shared_ptr<ov::Model>& model) {
  ov::preprocess::PrePostProcessor ends(model);
  ends.input().tensor().set_element_type(ov::element::f32);
  for (std::size_t i = 0; i < model->outputs().size(); ++i)
    ends.output(i).tensor().set_element_type(ov::element::f32);
  return ends.build();
}

ov::AnyMap configuration(const InferenceOptions& options) {
  ov::AnyMap config{ov::hint::performance_mode(options.mode == Mode::kThroughput
                                                   ? ov::hint::PerformanceMode::THROUGHPUT
                                                   : ov::hint::PerformanceMode::LATENCY)};
  // Left alone, the CPU plug-in takes bf16 where the processor has it: 1.6 to 1.9 times slower for small
  // networks.
  ov::AnyMap cpu{ov::hint::inference_precision(element_type(options.precision))};
  if (options.threads > 0) cpu.insert(ov::inference_num_threads(options.threads));
  if (options.device == "AUTO")
    config.insert(ov::device::properties("CPU", cpu));
  else if (options.device == "CPU")
    config.insert(cpu.begin(), cpu.end());
  else
    config.insert(ov::hint::inference_precision(element_type(options.precision)));
  if (!options.cache_dir.empty()) config.insert(ov::cache_dir(options.cache_dir.string()));
  return config;
}

Result<std::shared_ptr<ov::Model>> read_network(const ModelSpec& spec) {
  std::shared_ptr<ov::Model> model;
  try {
    // Not Core::read_model(): it tries every format in turn, and their readers complain on stderr about a
    // damaged file.
    const auto reader = ov::frontend::FrontEndManager().load_by_framework("onnx");
    model = reader->convert(reader->load(spec.file.string()));
  } catch (const std::exception& error) {
    return fail(ErrorCode::kCorrupt,
                "not an ONNX network that OpenVINO can read: " + shortened(error.what()));
  }
  if (model->inputs().empty() || model->outputs().empty())
    return fail(ErrorCode::kCorrupt,
                "not an ONNX network that OpenVINO can read: it has no inputs or no outputs");
  if (const auto checked = check_input(*model, spec.input); !checked) return tl::unexpected(checked.error());
  if (const auto fixed = fix_shape(*model, spec.input); !fixed) return tl::unexpected(fixed.error());
  return with_float_ends(model);
}

}  // namespace

Result<std::unique_ptr<InferenceBackend>> load_openvino(const ModelSpec& spec,
                                                        const InferenceOptions& options) try {
  if (const auto checked = check_device(options.device); !checked) return tl::unexpected(checked.error());
  const auto network = read_network(spec);
  if (!network) return tl::unexpected(network.error());
  const auto outputs = output_names(spec, names_of((*network)->outputs()), (*network)->outputs().size());
  if (!outputs) return tl::unexpected(outputs.error());
  auto model = core().compile_model(*network, options.device, configuration(options));
  const int slots =
      options.mode == Mode::kThroughput
          ? static_cast<int>(std::max(1U, model.get_property(ov::optimal_number_of_infer_requests)))
          : 1;
  return std::make_unique<OpenVinoBackend>(std::move(model), *outputs, slots);
} catch (const std::exception& error) {
  return fail(ErrorCode::kFailed, "compiling the network: " + shortened(error.what()));
}

std::string openvino_version() {
  return ov::get_openvino_version().buildNumber;
}

}  // namespace extperfc::detect
