// Definitions as strangers send them: the full text of a message, and the texts of services and actions.
#include "extperfc/translate/schema.hpp"

#include "test/fuzz/target.hpp"

namespace extperfc::fuzz {

namespace {

using translate::SchemaPtr;

/// What was read can be written, and reads as the same again.
void check_again(const SchemaPtr& schema) {
  const auto again = translate::parse_full_text(schema->type(), schema->full_text());
  require(again.has_value(), "a schema's own full text is read");
  require((*again)->md5() == schema->md5(), "a schema's own full text has its MD5");
  require(translate::same_layout(**again, *schema), "a schema's own full text has its layout");
  require(schema->min_size() >= schema->fixed_size().value_or(0), "a fixed size is the least size");
}

}  // namespace

void run(std::string_view input) {
  const translate::SchemaLimits limits{1U << 16U, 200, 8, 50, 1U << 16U};
  if (const auto schema = translate::parse_full_text("a_msgs/Fuzzed", input, limits)) check_again(*schema);
  const auto none = [](const std::string&) { return SchemaPtr(); };
  if (const auto service = translate::parse_service("a_msgs/Fuzzed", input, none, limits)) {
    check_again((*service)->request);
    check_again((*service)->response);
  }
  const auto goal_id = translate::parse_message("actionlib_msgs/GoalID", "time stamp\nstring id\n", none);
  const auto header =
      translate::parse_message("std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n", none);
  const auto status =
      translate::parse_message("actionlib_msgs/GoalStatus", "actionlib_msgs/GoalID goal_id\nuint8 status\n",
                               [&](const std::string&) { return *goal_id; });
  const auto known = [&](const std::string& type) -> SchemaPtr {
    if (type == "std_msgs/Header") return *header;
    if (type == "actionlib_msgs/GoalID") return *goal_id;
    return type == "actionlib_msgs/GoalStatus" ? *status : nullptr;
  };
  if (const auto action = translate::parse_action("a_msgs/Fuzzed", input, known, limits))
    check_again((*action)->action);
}

std::vector<std::string> seeds() {
  const std::string bar(80, '=');
  return {
      "uint8 A=1\nstring S= a # text\nbool b\nfloat64[] values\nstring[3] names\ntime t\nduration d # d\n",
      "Header header\nPoint[] points\n" + bar +
          "\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n" + bar +
          "\nMSG: a_msgs/Point\nfloat64 x\nfloat64 y\n",
      "b_msgs/One one\n" + bar + "\nMSG: b_msgs/One\nTwo[2] two\n" + bar +
          "\nMSG: b_msgs/Two\nint8 x\nbyte y\nchar z\n",
      "int32 a\nint32 b\n---\nint32 sum\n",
      "int32 goal\n---\nint32 result\n---\nint32 feedback\n",
      "float32 F=1.5e3\nint64 BIG=-9223372036854775808\nuint8[65536] many\n",
      "\xEF\xBB\xBFint32 x\r\n\tint8   y\r\n",
      "Fuzzed self\n",
      "",
  };
}

}  // namespace extperfc::fuzz
