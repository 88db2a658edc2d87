// Connection headers of TCPROS.
#include "extperfc/translate/tcpros.hpp"

#include "test/fuzz/target.hpp"

namespace extperfc::fuzz {

void run(std::string_view input) {
  const translate::ByteView bytes{reinterpret_cast<const std::uint8_t*>(input.data()), input.size()};
  const auto header = translate::decode_header(bytes);
  if (!header) {
    require(!header.error().message.empty(), "a refusal has a reason");
    return;
  }
  const auto encoded = translate::encode_header(*header);
  require(encoded.size() <= input.size() + 4, "a header does not grow");
  const auto again = translate::decode_header({encoded.data() + 4, encoded.size() - 4});
  require(again && *again == *header, "a header that was read is written and read as the same");
}

std::vector<std::string> seeds() {
  std::vector<std::string> all;
  for (const translate::ConnectionHeader& header :
       {translate::ConnectionHeader{
            {"topic", "/a"}, {"md5sum", "*"}, {"callerid", "/n"}, {"type", "std_msgs/String"}},
        translate::ConnectionHeader{{"service", "/s"}, {"probe", "1"}, {"md5sum", std::string(32, 'a')}},
        translate::ConnectionHeader{{"error", "no = such\ntopic"}}, translate::ConnectionHeader{}}) {
    const auto bytes = translate::encode_header(header);
    all.emplace_back(reinterpret_cast<const char*>(bytes.data()) + 4, bytes.size() - 4);
  }
  all.push_back(std::string("\xff\xff\xff\xff") + "a=b");
  return all;
}

}  // namespace extperfc::fuzz
