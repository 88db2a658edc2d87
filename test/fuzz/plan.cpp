// Two definitions and a message, all from strangers, divided by zero bytes: what compiles must run.
#include "extperfc/translate/plan.hpp"

#include <cstring>
#include <memory>

#include "test/fuzz/target.hpp"

namespace extperfc::fuzz {

namespace {

using translate::ByteBuffer;
using translate::Plan;

std::string_view take_part(std::string_view& rest) {
  const auto end = rest.find('\0');
  const auto part = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  return part;
}

void convert(const Plan& plan, std::string_view message) {
  const std::unique_ptr<std::uint8_t[]> bytes(new std::uint8_t[message.size()]);
  if (!message.empty()) std::memcpy(bytes.get(), message.data(), message.size());
  ByteBuffer out;
  const auto done = plan.convert({bytes.get(), message.size()}, out, 1'000);
  if (!done) {
    require(out.size() == 0 && !done.error().message.empty(), "a refusal has a reason and leaves nothing");
    return;
  }
  const auto reader = Plan::compile(plan.to(), plan.to(), {});
  ByteBuffer copy;
  require(reader && (*reader)->convert(out.view(), copy), "what was converted is a message");
  require(copy.size() == out.size(), "a checked copy has the same size");
}

}  // namespace

void run(std::string_view input) {
  const translate::SchemaLimits limits{1U << 14U, 50, 6, 20, 1000};
  const auto from_text = take_part(input), to_text = take_part(input);
  const auto from = translate::parse_full_text("a_msgs/From", from_text, limits);
  const auto to = translate::parse_full_text("a_msgs/From", to_text, limits);
  if (!from || !to) return;
  translate::PlanOptions options;
  options.shift_times = true;
  options.frame_slash = translate::PlanOptions::Slash::kStrip;
  options.max_message_bytes = 1U << 20U;
  const auto plan = Plan::compile(*from, *to, {}, options);
  if (!plan) return;
  require(!translate::same_layout(**from, **to) || !(*plan)->notes().empty() || (*from)->fields().empty(),
          "a plan describes its fields");
  for (const auto& line : (*plan)->describe()) require(!line.empty(), "a step has a text");
  convert(**plan, input);
  if ((*from)->min_size() > options.max_message_bytes) return;
  ByteBuffer zeros;
  translate::serialize_default(**from, zeros);
  convert(**plan, {reinterpret_cast<const char*>(zeros.data()), zeros.size()});
}

std::vector<std::string> seeds() {
  const std::string bar = std::string(80, '=') + "\nMSG: ";
  const std::string header = bar + "std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
  const std::string end(1, '\0');
  const std::string zeros(64, '\0');
  return {
      "int8 a\nstring s\n" + end + "string s\nint64 a\nfloat32 b\n" + end + std::string("\5\2\0\0\0hi", 7),
      "Header header\nfloat64[] v\n" + header + end + "float32[] v\nHeader header\n" + header + end + zeros,
      "P[] ps\n" + bar + "a_msgs/P\nfloat64 x\nstring n\n" + end + "P[] ps\n" + bar +
          "a_msgs/P\nstring n\nfloat64 x\nint8 z\n" + end + std::string("\1\0\0\0", 4) + zeros,
      "int16[4] f\ntime t\nduration d\n" + end + "int16[] f\nduration t\ntime d\n" + end + zeros,
      "string[] a\nuint8[] b\n" + end + "uint8[] b\nstring[] a\n" + end +
          std::string("\1\0\0\0\1\0\0\0x\2\0\0\0yz", 15),
      "bool[] a\n" + end + "uint8[] a\n" + end + zeros,
  };
}

}  // namespace extperfc::fuzz
