#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extperfc/translate/schema.hpp"

namespace extperfc::translate {
namespace {

SchemaPtr nothing(const std::string& /*type*/) {
  return nullptr;
}

SchemaPtr parse(const std::string& type, const std::string& text, const FindSchema& find = nothing) {
  auto schema = parse_message(type, text, find);
  EXPECT_TRUE(schema) << schema.error().message;
  return schema ? *schema : nullptr;
}

std::string problem(const std::string& text, const SchemaLimits& limits = {}) {
  const auto schema = parse_message("pkg/Name", text, nothing, limits);
  EXPECT_FALSE(schema) << text;
  return schema ? "" : schema.error().message;
}

SchemaPtr header() {
  return parse("std_msgs/Header", "uint32 seq\ntime stamp\nstring frame_id\n");
}
SchemaPtr point() {
  return parse("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n");
}
SchemaPtr known(const std::string& type) {
  if (type == "std_msgs/Header") return header();
  if (type == "geometry_msgs/Point") return point();
  return nullptr;
}

TEST(ParseMessage, Md5OfPublishedTypes) {
  EXPECT_EQ("d41d8cd98f00b204e9800998ecf8427e", parse("std_msgs/Empty", "")->md5());
  EXPECT_EQ("992ce8a1687cec8c8bd883ec73ca41d1", parse("std_msgs/String", "string data\n")->md5());
  EXPECT_EQ("2176decaecbce78abc3b96ef049fabed", header()->md5());
  EXPECT_EQ("4a842b65f413084dc2b10fb484ea7f17", point()->md5());
  // `byte` and `char` keep their names in the MD5.
  EXPECT_EQ("ad736a2e8818154c487bb80fe42ce43b", parse("std_msgs/Byte", "byte data")->md5());
  EXPECT_EQ("1bf77f25acecdedba0e224b162199717", parse("std_msgs/Char", "char data")->md5());
  EXPECT_EQ("c63aecb41bfdfd6b7e1fac37c7cbe7bf",
            parse("geometry_msgs/PointStamped", "Header header\nPoint point", known)->md5());
}

TEST(ParseMessage, FieldsCarryWhatTheWireNeeds) {
  const auto schema =
      parse("pkg/All",
            "byte a\nchar b\nfloat32[] c\nint16[3] d\nHeader h\ngeometry_msgs/Point[2] p\nduration e", known);
  ASSERT_EQ(7U, schema->fields().size());
  const auto& fields = schema->fields();
  EXPECT_EQ(Primitive::kInt8, fields[0].primitive);
  EXPECT_EQ("byte", fields[0].written_type);
  EXPECT_EQ(Primitive::kUint8, fields[1].primitive);
  EXPECT_EQ(Arity::kVariable, fields[2].arity);
  EXPECT_EQ(Arity::kFixed, fields[3].arity);
  EXPECT_EQ(3U, fields[3].fixed_count);
  EXPECT_EQ("Header", fields[4].written_type);
  EXPECT_EQ("std_msgs/Header", fields[4].message->type());
  EXPECT_EQ("geometry_msgs/Point[2] p", to_string(fields[5]));
  EXPECT_EQ(1U + 1 + 4 + 6 + (4 + 8 + 4) + 48 + 8, schema->min_size());
  EXPECT_FALSE(schema->fixed_size());
  EXPECT_TRUE(schema->has_time());
  EXPECT_EQ(1U, schema->depth());
  EXPECT_EQ(7U + 3 + 3, schema->expanded_fields());
  EXPECT_EQ(&fields[3], schema->find("d"));
  EXPECT_EQ(nullptr, schema->find("nothing"));
  EXPECT_EQ(24U, point()->fixed_size());
  EXPECT_FALSE(point()->has_time());
}

TEST(ParseMessage, ConstantsCountAsWritten) {
  const auto schema = parse("pkg/Name",
                            "  int32 A = -5 # not this\n"
                            "string TEXT =  say \"#1\" = it # is part \t\n"
                            "uint8\tB=\t255\n"
                            "float64 PI=3.1400\n"
                            "bool YES=True\n"
                            "char C=65\n"
                            "string EMPTY=\n");
  ASSERT_EQ(7U, schema->constants().size());
  EXPECT_EQ("-5", schema->constants()[0].value);
  EXPECT_EQ("say \"#1\" = it # is part", schema->constants()[1].value);
  EXPECT_EQ("255", schema->constants()[2].value);
  EXPECT_EQ("3.1400", schema->constants()[3].value);
  EXPECT_EQ("True", schema->constants()[4].value);
  EXPECT_EQ("", schema->constants()[6].value);
  EXPECT_TRUE(schema->fields().empty());
}

TEST(ParseMessage, LayoutOfTheTextDoesNotMatter) {
  const auto plain = parse("pkg/Name", "int32 A=1\nfloat64[] x\nstring y\n");
  const auto wild =
      parse("pkg/Name", "# about\r\n\r\n float64[]  \t x # metres\r\nint32   A  =  1\r\n\tstring\ty\r\n");
  EXPECT_EQ(plain->md5(), wild->md5());
  EXPECT_EQ(plain->text(), wild->text());
  EXPECT_EQ(plain->md5(), parse("pkg/Name", "int32 A=1\rfloat64[] x\rstring y")->md5())
      << "lines that end in CR";
}

TEST(ParseMessage, ShortNamesAreOfTheSamePackage) {
  const auto inner = parse("pkg/Inner", "int32 a");
  const auto find = [&](const std::string& type) { return type == "pkg/Inner" ? inner : known(type); };
  EXPECT_EQ(parse("pkg/Outer", "Inner i", find)->md5(), parse("pkg/Outer", "pkg/Inner i", find)->md5());
  EXPECT_FALSE(parse_message("other/Outer", "Inner i", find));
  // As in genmsg, only the single `Header` is the one of std_msgs.
  EXPECT_FALSE(parse_message("pkg/Outer", "Header[] h", find));
  EXPECT_TRUE(parse_message("pkg/Outer", "std_msgs/Header[] h", find));
}

TEST(ParseMessage, ArraysOfMessagesHaveTheMd5OfOne) {
  const auto one = parse("pkg/Name", "geometry_msgs/Point p", known);
  const auto many = parse("pkg/Name", "geometry_msgs/Point[] p", known);
  const auto three = parse("pkg/Name", "geometry_msgs/Point[3] p", known);
  EXPECT_EQ(one->md5(), many->md5());
  EXPECT_EQ(one->md5(), three->md5());
  EXPECT_FALSE(same_layout(*one, *many));
  EXPECT_FALSE(same_layout(*one, *three));
  EXPECT_FALSE(same_layout(*many, *three));
  EXPECT_TRUE(same_layout(*three, *parse("pkg/Other", "geometry_msgs/Point[3] p", known)));
  EXPECT_NE(parse("pkg/Name", "float64 p")->md5(), parse("pkg/Name", "float64[] p")->md5());
}

TEST(SameLayout, ConstantsAndNamesOfTypesDoNotCount) {
  const auto with = parse("pkg/A", "int32 X=1\nbyte b\nstring s");
  const auto without = parse("pkg/B", "int8 b\nstring s");
  EXPECT_NE(with->md5(), without->md5());
  EXPECT_TRUE(same_layout(*with, *without));
  EXPECT_FALSE(same_layout(*with, *parse("pkg/A", "string s\nbyte b"))) << "order";
  EXPECT_FALSE(same_layout(*with, *parse("pkg/A", "byte b\nstring t"))) << "names";
  EXPECT_FALSE(same_layout(*with, *parse("pkg/A", "byte b"))) << "one more";
}

TEST(ParseMessage, RefusesWhatIsNoDefinition) {
  EXPECT_NE(std::string::npos, problem("int32 a\nint32").find("pkg/Name line 2"));
  EXPECT_NE(std::string::npos, problem("int32 a\n\nfloat32 a").find("line 3: field a appears twice"));
  for (const auto* text : {"int32 1a",
                           "int32 a b",
                           "int32 a-b",
                           "int32[ a",
                           "int32] a",
                           "int32[][] a",
                           "int32[-1] a",
                           "int32[x] a",
                           "int32[3]] a",
                           "int32[03] a",
                           "int32[99999999999] a",
                           "int32 [] a",
                           "a/b/c d",
                           "/b c",
                           "a/ b",
                           "a//b c",
                           "[] a",
                           "int8 A=128",
                           "uint8 A=-1",
                           "uint8 A=256",
                           "int32 A=x",
                           "int32 A=1.5",
                           "int32 A=0x10",
                           "int32 A=",
                           "float32 A=x",
                           "float32 A=0x1p3",
                           "bool A=maybe",
                           "time A=1",
                           "duration A=1",
                           "geometry_msgs/Point A=1",
                           "int32 =1",
                           "=",
                           "int32[] A=1",
                           "int32 A B=1",
                           "int32 A=1=2",
                           "string[] s = x",
                           "int64 A=9223372036854775808",
                           "\x01 b",
                           "int32 \xc3\xa4"})
    EXPECT_FALSE(problem(text).empty()) << text;
  for (const auto* type :
       {"", "Name", "pkg/", "/Name", "pkg/sub/Name", "../pkg/Name", "pkg/Na me", "pkg/1", "pkg/Name\n"})
    EXPECT_FALSE(parse_message(type, "int32 a", nothing)) << type;
  EXPECT_FALSE(parse_message(std::string(300, 'a') + "/Name", "int32 a", nothing));
}

TEST(ParseMessage, AcceptsEveryValueThatATypeHolds) {
  for (const auto* text :
       {"int8 A=-128", "uint8 A=+7", "uint64 A=18446744073709551615", "int64 A=-9223372036854775808",
        "float32 A=1e-3", "float64 A=inf", "float64 A=nan", "float64 A=.5", "float64 A=5.", "bool A=0",
        "bool A=False", "byte A=-1", "char A=255", "string A=#", "int32[0] a", "int32[16777216] a"})
    EXPECT_TRUE(parse_message("pkg/Name", text, nothing)) << text;
}

TEST(ParseMessage, NamesTheEmbeddedTypeThatIsMissing) {
  const auto message = problem("int32 a\nother_msgs/Thing[] b");
  EXPECT_NE(std::string::npos, message.find("line 2: field b embeds other_msgs/Thing")) << message;
}

TEST(ParseMessage, Limits) {
  SchemaLimits limits;
  limits.fields = 3;
  EXPECT_TRUE(parse_message("pkg/Name", "int32 A=1\nint32 b\nint32 c", nothing, limits));
  EXPECT_NE("", problem("int32 A=1\nint32 b\nint32 c\nint32 d", limits));
  limits = {};
  limits.text_bytes = 10;
  EXPECT_NE("", problem("int32 abcdefgh", limits));
  limits = {};
  limits.fixed_count = 100;
  EXPECT_TRUE(parse_message("pkg/Name", "int32[100] a", nothing, limits));
  EXPECT_NE("", problem("int32[101] a", limits));
}

TEST(ParseMessage, ArraysOfArraysThatNoMessageHolds) {
  // 2^24 * 2^24 * 2^24 elements: the product leaves 64 bits.
  SchemaPtr inner = parse("pkg/L0", "float64[16777216] a");
  ASSERT_TRUE(inner);
  EXPECT_EQ(std::size_t{8} << 24U, inner->fixed_size());
  const auto find = [&](const std::string& /*type*/) { return inner; };
  const auto next = parse_message("pkg/L1", "pkg/L0[16777216] a", find);
  ASSERT_FALSE(next);
  EXPECT_NE(std::string::npos, next.error().message.find("4 GiB"));
  // Made by hand the sizes stop at the largest number instead of running over.
  Field field{"a", "pkg/L0", Primitive::kMessage, Arity::kFixed, 1U << 31U, inner};
  auto huge =
      std::make_shared<const MessageSchema>("pkg/L1", std::vector<Field>{field}, std::vector<Constant>{});
  field.message = huge;
  const MessageSchema more("pkg/L2", {field}, {});
  EXPECT_EQ(std::numeric_limits<std::size_t>::max(), more.min_size());
  EXPECT_FALSE(more.fixed_size());
}

TEST(ParseMessage, EmbeddingThatDoublesAtEachLevel) {
  SchemaPtr inner = parse("pkg/L0", "");
  for (int level = 1;; ++level) {
    const auto find = [&](const std::string& /*type*/) { return inner; };
    const auto type = "pkg/L" + std::to_string(level);
    const auto below = "L" + std::to_string(level - 1);
    auto next = parse_message(type, below + " a\n" + below + " b\n", find);
    if (!next) {
      EXPECT_NE(std::string::npos, next.error().message.find("50000 fields")) << next.error().message;
      EXPECT_EQ(15, level);
      break;
    }
    ASSERT_LT(level, 20);
    inner = *next;
  }
}

TEST(ParseMessage, DepthOfEmbedding) {
  SchemaPtr inner = parse("pkg/L0", "int8 a");
  const auto find = [&](const std::string& /*type*/) { return inner; };
  for (int level = 1; level <= 32; ++level) {
    auto next = parse_message("pkg/L" + std::to_string(level), "L a", find);
    ASSERT_TRUE(next) << level << next.error().message;
    inner = *next;
  }
  EXPECT_FALSE(parse_message("pkg/L33", "L a", find));
}

TEST(ParseService, Md5IsOfBothHalves) {
  const auto add = parse_service("rospy_tutorials/AddTwoInts", "int64 a\nint64 b\n---\nint64 sum\n", nothing);
  ASSERT_TRUE(add) << add.error().message;
  EXPECT_EQ("6a2e34150c00229791cc89ff309fff21", (*add)->md5);
  EXPECT_EQ("rospy_tutorials/AddTwoIntsRequest", (*add)->request->type());
  EXPECT_EQ(8U, (*add)->response->fixed_size());
  const auto empty = parse_service("std_srvs/Empty", "---", nothing);
  ASSERT_TRUE(empty);
  EXPECT_EQ("d41d8cd98f00b204e9800998ecf8427e", (*empty)->md5);
  const auto set_bool =
      parse_service("std_srvs/SetBool", "bool data # e.g.\n---\r\nbool success\nstring message\n", nothing);
  ASSERT_TRUE(set_bool);
  EXPECT_EQ("09fb03525b03e7ea1fd3992bafd87e16", (*set_bool)->md5);
  EXPECT_FALSE(parse_service("pkg/Name", "int32 a\n", nothing)) << "no line of dashes";
  EXPECT_FALSE(parse_service("pkg/Name", "int32 a\n---\n---\n", nothing));
  const auto wrong = parse_service("pkg/Name", "int32 a\n---\nint32 b\nint32 b\n", nothing);
  ASSERT_FALSE(wrong);
  EXPECT_NE(std::string::npos, wrong.error().message.find("line 4")) << wrong.error().message;
}

TEST(ParseAction, DerivesSevenMessages) {
  const auto id = parse("actionlib_msgs/GoalID", "time stamp\nstring id\n");
  const auto status =
      parse("actionlib_msgs/GoalStatus",
            "uint8 PENDING=0\nuint8 ACTIVE=1\nuint8 PREEMPTED=2\nuint8 SUCCEEDED=3\nuint8 ABORTED=4\n"
            "uint8 REJECTED=5\nuint8 PREEMPTING=6\nuint8 RECALLING=7\nuint8 RECALLED=8\nuint8 LOST=9\n"
            "GoalID goal_id\nuint8 status\nstring text\n",
            [&](const std::string& /*type*/) { return id; });
  const auto find = [&](const std::string& type) {
    return type == id->type() ? id : type == status->type() ? status : known(type);
  };
  const auto test =
      parse_action("actionlib/Test", "int32 goal\n---\nint32 result\n---\nint32 feedback\n", find);
  ASSERT_TRUE(test) << test.error().message;
  EXPECT_EQ("18df0149936b7aa95588e3862476ebde", (*test)->goal->md5());
  EXPECT_EQ("348369c5b403676156094e8c159720bf", (*test)->action_goal->md5());
  EXPECT_EQ("3d669e3a63aa986c667ea7b0f46ce85e", (*test)->action_result->md5());
  EXPECT_EQ("6d3d0bf7fb3dda24779c010a9f3eb7cb", (*test)->action_feedback->md5());
  EXPECT_EQ("991e87a72802262dfbe5d1b3cf6efc9a", (*test)->action->md5());
  EXPECT_EQ("actionlib/TestAction", (*test)->action->type());
  EXPECT_FALSE(parse_action("actionlib/Test", "int32 goal\n---\nint32 result\n", find));
  EXPECT_FALSE(parse_action("actionlib/Test", "---\n---\n", nothing)) << "actionlib_msgs is not known";
}

TEST(EmbeddedTypes, InOrderOfFirstUse) {
  const auto types =
      embedded_types("pkg/Name", "B b\nHeader h\n---\nother/C[] c\nB[2] again\nint32 x\nint32 K=3\n");
  ASSERT_TRUE(types) << types.error().message;
  EXPECT_EQ((std::vector<std::string>{"pkg/B", "std_msgs/Header", "other/C"}), *types);
  EXPECT_FALSE(embedded_types("pkg/Name", "what is this"));
}

}  // namespace
}  // namespace extperfc::translate
