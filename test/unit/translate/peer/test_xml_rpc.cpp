#include <clocale>
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "extperfc/base/rng.hpp"
#include "extperfc/translate/rpc.hpp"

namespace extperfc::translate {
namespace {

std::string response_of(const std::string& value) {
  return "<?xml version='1.0'?><methodResponse><params><param>" + value +
         "</param></params></methodResponse>";
}

XmlValue decoded(const std::string& value) {
  const auto result = decode_response(response_of(value));
  EXPECT_TRUE(result) << value << ": " << (result ? "" : result.error().message);
  return result ? *result : XmlValue();
}

XmlValue there_and_back(const XmlValue& value) {
  const auto result = decode_response(encode_response(value));
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? *result : XmlValue();
}

TEST(XmlRpc, ReadsEveryType) {
  EXPECT_EQ(decoded("<value><int> 42\n</int></value>"), XmlValue(42));
  EXPECT_EQ(decoded("<value><i4>-2147483648</i4></value>"),
            XmlValue(std::numeric_limits<std::int32_t>::min()));
  EXPECT_EQ(decoded("<value><i4>+7</i4></value>"), XmlValue(7));
  EXPECT_EQ(decoded("<value><boolean>1</boolean></value>"), XmlValue(true));
  EXPECT_EQ(decoded("<value><double>-1.5e-3</double></value>"), XmlValue(-1.5e-3));
  EXPECT_EQ(decoded("<value><double>3</double></value>"), XmlValue(3.0));
  EXPECT_EQ(decoded("<value><string>a</string></value>"), XmlValue("a"));
  EXPECT_EQ(decoded("<value>bare</value>"), XmlValue("bare"));
  EXPECT_EQ(decoded("<value/>"), XmlValue(""));
  EXPECT_EQ(decoded("<value><string/></value>"), XmlValue(""));
  EXPECT_EQ(decoded("<value><nil/></value>"), XmlValue());
  EXPECT_EQ(decoded("<value><base64>AAEC\n/w==</base64></value>"), XmlValue(XmlBinary{{"\0\1\2\xff", 4}}));
  const auto time = decoded("<value><dateTime.iso8601>20061121T09:30:00</dateTime.iso8601></value>");
  ASSERT_NE(time.as<XmlDateTime>(), nullptr);
  EXPECT_EQ(time.as<XmlDateTime>()->text, "20061121T09:30:00");
  EXPECT_EQ(decoded("<value><array><data/></array></value>"), XmlValue(XmlArray{}));
  EXPECT_EQ(
      decoded("<value><array> <data> <value>1</value>\n <value><int>2</int></value></data></array></value>"),
      XmlValue(XmlArray{"1", 2}));
  EXPECT_EQ(
      decoded(
          "<value><struct>\n<member><name>a</name>\n<value><int>1</int></value></member></struct></value>"),
      XmlValue(XmlStruct{{"a", 1}}));
}

TEST(XmlRpc, KeepsEveryByteOfAString) {
  for (const std::string text :
       {" ", "   \n\t", "\n leading", "trailing \n", " a  b ", "<a>&amp;</a>", "]]>", "line\r\nend\r",
        "\xc3\xa4\xe2\x82\xac\xf0\x9f\xa4\x96", "\"quoted\" 'too'", ""}) {
    EXPECT_EQ(there_and_back(text), XmlValue(text));
    EXPECT_EQ(there_and_back(XmlStruct{{text, 1}}), XmlValue(XmlStruct{{text, 1}}));
  }
  EXPECT_EQ(decoded("<value>  </value>"), XmlValue("  "));
  EXPECT_EQ(decoded("<value><string>a<!-- b --> c<![CDATA[<&>]]></string></value>"), XmlValue("a c<&>"));
  EXPECT_EQ(decoded("<value>raw\r\nends</value>"), XmlValue("raw\r\nends"));
}

TEST(XmlRpc, ReadsEntities) {
  EXPECT_EQ(decoded("<value>&lt;&gt;&amp;&quot;&apos;&#65;&#x42;&#x20AC;&#x1F916;</value>"),
            XmlValue("<>&\"'AB\xe2\x82\xac\xf0\x9f\xa4\x96"));
  for (const std::string text :
       {"&", "&;", "&unknown;", "&#;", "&#x;", "&#0;", "&#xD800;", "&#x110000;", "&#99999999999;"})
    EXPECT_EQ(decoded("<value>" + text + "</value>"), XmlValue(text)) << "stays as it is";
}

TEST(XmlRpc, WhatXmlCannotHoldBecomesAQuestionMark) {
  const std::string bad("a\0b\x01\x1f\xff\xc0\x80\xed\xa0\x80z", 12);
  const auto text = there_and_back(bad);
  ASSERT_NE(text.as<std::string>(), nullptr);
  EXPECT_EQ(*text.as<std::string>(), "a?b????????z");
}

TEST(XmlRpc, DoublesAreExactInEveryLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8"})
    if (std::setlocale(LC_ALL, name) != nullptr) break;  // a comma where there is such a locale
  Rng rng(3);
  for (int i = 0; i < 2'000; ++i) {
    const double value = rng.normal(0.0, 1.0) * std::pow(10.0, rng.integer(-300, 300));
    EXPECT_EQ(there_and_back(value), XmlValue(value));
  }
  EXPECT_EQ(encode_response(0.1).find("<double>0.1</double>") == std::string::npos, false);
  EXPECT_EQ(encode_response(2.0).find("<double>2.0</double>") == std::string::npos, false);
  const auto infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(there_and_back(-infinity), XmlValue(-infinity));
  EXPECT_EQ(there_and_back(5e-324), XmlValue(5e-324));
  const auto nan = there_and_back(std::nan(""));
  ASSERT_NE(nan.as<double>(), nullptr);
  EXPECT_TRUE(std::isnan(*nan.as<double>()));
  std::setlocale(LC_ALL, before.c_str());
}

TEST(XmlRpc, ReadsCallsOfBothDialects) {
  const auto python = decode_call(
      "<?xml "
      "version='1.0'?>\n<methodCall>\n<methodName>requestTopic</"
      "methodName>\n<params>\n<param>\n<value><string>"
      "/node</string></value>\n</"
      "param>\n<param>\n<value><array><data>\n<value><array><data>\n<value><string>TCPROS"
      "</string></value>\n</data></array></value>\n</data></array></value>\n</param>\n</params>\n</"
      "methodCall>\n");
  ASSERT_TRUE(python) << python.error().message;
  EXPECT_EQ(python->method, "requestTopic");
  EXPECT_EQ(XmlValue(python->arguments), XmlValue(XmlArray{"/node", XmlArray{XmlArray{"TCPROS"}}}));
  const auto roscpp = decode_call(
      "<?xml "
      "version=\"1.0\"?>\r\n<methodCall><methodName>getPid</methodName>\r\n<params><param><value>/node</"
      "value>"
      "</param></params></methodCall>\r\n");
  ASSERT_TRUE(roscpp) << roscpp.error().message;
  EXPECT_EQ(roscpp->arguments.size(), 1U);
  const auto bare = decode_call("<methodCall><methodName>shutdown</methodName></methodCall>");
  ASSERT_TRUE(bare);
  EXPECT_TRUE(bare->arguments.empty());
}

TEST(XmlRpc, AFaultIsAnErrorWithItsText) {
  const auto fault = decode_response(encode_fault(4, "too <many>"));
  ASSERT_FALSE(fault);
  EXPECT_EQ(fault.error().code, ErrorCode::kFailed);
  EXPECT_NE(fault.error().message.find("too <many>"), std::string::npos);
}

TEST(XmlRpc, RefusesWhatIsNotXmlRpc) {
  for (const std::string value : {"",
                                  "<value>",
                                  "<value><int>1</value>",
                                  "<value><int></int></value>",
                                  "<value><int>2147483648</int></value>",
                                  "<value><int>1x</int></value>",
                                  "<value><boolean>2</boolean></value>",
                                  "<value><double>1,5</double></value>",
                                  "<value><double>1.5 2</double></value>",
                                  "<value><base64>A</base64></value>",
                                  "<value><base64>A===</base64></value>",
                                  "<value><base64>A*==</base64></value>",
                                  "<value><float>1</float></value>",
                                  "<value>text<int>1</int></value>",
                                  "<value><int>1</int>text</value>",
                                  "<value><int>1</int><int>2</int></value>",
                                  "<value><struct><member><name>a</name></member></struct></value>",
                                  "<value><array><data><value/></array></value>",
                                  "<value><array><data>x</data></array></value>",
                                  "<value a='",
                                  "<value><!-- ",
                                  "<value><![CDATA[ ",
                                  "<>",
                                  "<value></value",
                                  "</value>"}) {
    const auto result = decode_response(response_of(value));
    ASSERT_FALSE(result) << value;
    EXPECT_EQ(result.error().code, ErrorCode::kCorrupt) << value;
  }
  EXPECT_FALSE(decode_response(response_of("<value/>") + "<more/>"));
  EXPECT_FALSE(decode_response("<!DOCTYPE x [<!ENTITY a 'aaaa'>]>" + response_of("<value>&a;</value>")));
  EXPECT_FALSE(decode_response("<html>nginx</html>"));
  EXPECT_FALSE(decode_call(response_of("<value/>")));
}

TEST(XmlRpc, BoundsDepthCountAndSize) {
  RpcLimits limits;
  const auto nested = [](std::size_t depth) {
    XmlValue value = 1;
    for (std::size_t i = 1; i < depth; ++i) value = XmlArray{value};
    return encode_response(value);
  };
  EXPECT_TRUE(decode_response(nested(limits.depth), limits));
  EXPECT_FALSE(decode_response(nested(limits.depth + 1), limits));
  std::string deep;
  for (int i = 0; i < 1'000'000; ++i) deep += "<value><array><data>";
  EXPECT_FALSE(decode_response(deep)) << "no stack is used up";
  limits.values = 1'000;
  EXPECT_TRUE(decode_response(encode_response(XmlArray(999)), limits));
  EXPECT_FALSE(decode_response(encode_response(XmlArray(1'000)), limits));
  limits.body_bytes = 100;
  EXPECT_FALSE(decode_response(encode_response(std::string(100, 'a')), limits));
}

XmlValue random_value(Rng& rng, int depth) {
  const auto text = [&rng] {
    std::string result;
    for (int i = rng.integer(0, 12); i > 0; --i)
      result += std::string("aZ9 \n\t\r<>&'\"/;#]").substr(static_cast<std::size_t>(rng.integer(0, 15)), 1);
    return result;
  };
  switch (rng.integer(0, depth > 0 ? 7 : 5)) {
    case 0:
      return rng.chance(0.5);
    case 1:
      return rng.integer(-1'000'000, 1'000'000);
    case 2:
      return rng.normal(0.0, 1e3);
    case 3:
      return text();
    case 4:
      return XmlBinary{text()};
    case 5:
      return "";
    case 6: {
      XmlArray values;
      for (int i = rng.integer(0, 4); i > 0; --i) values.push_back(random_value(rng, depth - 1));
      return values;
    }
    default:
      break;
  }
  XmlStruct members;
  for (int i = rng.integer(0, 4); i > 0; --i) members[text()] = random_value(rng, depth - 1);
  return members;
}

TEST(XmlRpc, WhatIsWrittenReadsBackTheSame) {
  Rng rng(11);
  for (int i = 0; i < 2'000; ++i) {
    const auto value = random_value(rng, 4);
    ASSERT_EQ(there_and_back(value), value) << encode_response(value);
    const auto call = decode_call(encode_call("m", {value, value}));
    ASSERT_TRUE(call);
    ASSERT_EQ(XmlValue(call->arguments), XmlValue(XmlArray{value, value}));
  }
}

TEST(XmlRpc, DamagedDocumentsNeverCrash) {
  Rng rng(12);
  for (int i = 0; i < 20'000; ++i) {
    auto text = encode_response(random_value(rng, 3));
    for (int changes = rng.integer(1, 4); changes > 0 && !text.empty(); --changes) {
      const auto at = static_cast<std::size_t>(rng.integer(0, static_cast<int>(text.size()) - 1));
      if (rng.chance(0.3))
        text.resize(at);
      else if (rng.chance(0.3))
        text.erase(at, static_cast<std::size_t>(rng.integer(1, 10)));
      else
        text[at] = static_cast<char>(rng.integer(0, 255));
    }
    const auto result = decode_response(text);
    if (!result) {
      ASSERT_FALSE(result.error().message.empty());
    }
  }
}

TEST(ParseUri, TakesHostsNumbersAndIPv6) {
  const auto check = [](const char* text, const char* host, int port) {
    const auto uri = parse_uri(text);
    ASSERT_TRUE(uri) << text;
    EXPECT_EQ(uri->host, host);
    EXPECT_EQ(uri->port, port);
  };
  check("http://baxter.local:11311", "baxter.local", 11311);
  check("http://10.0.0.1:1/", "10.0.0.1", 1);
  check("rosrpc://ws:65535", "ws", 65535);
  check("http://[fe80::1]:80/RPC2", "fe80::1", 80);
  for (const char* text :
       {"", "host:1", "http://", "http://host", "http://host/", "http://:1", "http://host:", "http://host:0",
        "http://host:65536", "http://host:1x", "http://[::1:80", "http://a b:1", "http://host:-1",
        "://host:1", "http://host\r\n:1"}) {
    const auto uri = parse_uri(text);
    ASSERT_FALSE(uri) << text;
    EXPECT_EQ(uri.error().code, ErrorCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace extperfc::translate
