// Calls and responses of XML-RPC, and the HTTP around them.
#include "extperfc/translate/rpc.hpp"

#include "test/fuzz/target.hpp"
#include "translate/peer/http_message.hpp"

namespace extperfc::fuzz {

namespace {

using translate::HttpReader;
using translate::RpcLimits;
using translate::XmlArray;
using translate::XmlValue;

RpcLimits small() {
  RpcLimits limits;
  limits.header_bytes = 1U << 12U;
  limits.body_bytes = 1U << 16U;
  limits.depth = 16;
  return limits;
}

void decode(std::string_view xml) {
  const RpcLimits limits = small();
  if (const auto call = translate::decode_call(xml, limits)) {
    // Bytes that are no UTF-8 are written as other characters, so the first text may differ from the second.
    const auto once = translate::encode_call(call->method, call->arguments);
    const auto again = translate::decode_call(once);
    require(again.has_value(), "a call that was read is written and read again");
    require(translate::encode_call(again->method, again->arguments) == once, "and is written the same then");
  }
  if (const auto value = translate::decode_response(xml, limits)) {
    const auto once = translate::encode_response(*value);
    const auto again = translate::decode_response(once);
    require(again.has_value(), "a response that was read is written and read again");
    require(translate::encode_response(*again) == once, "and is written the same then");
  }
  static_cast<void>(translate::parse_uri(xml));
}

/// One connection's bytes, in pieces: the reader comes to an end, and takes no more than there is.
void read_stream(HttpReader::Kind kind, std::string_view input, std::size_t piece) {
  HttpReader reader(kind, small());
  std::string waiting;
  auto step = HttpReader::Step::kMore;
  while (step != HttpReader::Step::kBroken && (!input.empty() || step == HttpReader::Step::kDone)) {
    if (step == HttpReader::Step::kDone) decode(reader.take().body);
    waiting += input.substr(0, piece);
    input.remove_prefix(std::min(piece, input.size()));
    step = reader.read(waiting);
    require(reader.buffered() <= small().body_bytes, "a body keeps within its bound");
  }
  if (step == HttpReader::Step::kMore) step = reader.end_of_stream();
  if (step == HttpReader::Step::kBroken) require(!reader.problem().empty(), "a refusal has a reason");
}

}  // namespace

void run(std::string_view input) {
  decode(input);
  for (const auto kind : {HttpReader::Kind::kRequest, HttpReader::Kind::kResponse})
    for (const std::size_t piece : {std::size_t{1}, std::size_t{1000}})
      if (piece > 1 || input.size() < 2000) read_stream(kind, input, piece);
}

std::vector<std::string> seeds() {
  const XmlArray arguments{XmlValue("/caller"),
                           XmlValue(7),
                           XmlValue(true),
                           XmlValue(1.5),
                           XmlValue(XmlArray{XmlValue("a<&>"), XmlValue(XmlArray{})}),
                           XmlValue(translate::XmlStruct{{"k", XmlValue(translate::XmlBinary{"\1\2\3"})}})};
  const auto call = translate::encode_call("publisherUpdate", arguments);
  const auto response = translate::encode_response(XmlValue(arguments));
  const std::string chunked =
      "POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n4\r\n<a/>\r\n0\r\n\r\n";
  const std::string head = "<?xml version='1.0'?>";
  return {
      call,
      response,
      translate::encode_fault(-1, "no"),
      translate::http_request("host:1", "/RPC2", call) + translate::http_request("host:1", "/", call),
      translate::http_response(200, true, response),
      translate::http_response(404, false, ""),
      chunked,
      "POST / HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n",
      "GET / HTTP/1.0\r\n\r\n",
      "HTTP/1.0 200 OK\r\n\r\n" + response,
      head + "<!-- c --><methodResponse><params><param><value><i4>-2147483648</i4></value></param></params>" +
          "</methodResponse>",
      head + "<methodCall><methodName>m</methodName><params><param><value>bare &#65;<![CDATA[x]]></value>" +
          "</param></params></methodCall>",
      "http://host:11311/",
      "rosrpc://[::1]:80"};
}

}  // namespace extperfc::fuzz
