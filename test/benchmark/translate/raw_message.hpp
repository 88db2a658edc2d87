#pragma once

#include <cstdint>
#include <cstring>
#include <memory>

#include <ros/message_traits.h>
#include <ros/serialization.h>

namespace extperfc::benchmark {

/// A serialized message of any type: subscribes to any type, and is published under the type and MD5
/// that the publisher was advertised with.
struct RawMessage {
  std::shared_ptr<std::uint8_t[]> bytes;  // NOLINT(*-avoid-c-arrays): uninitialised, unlike a vector's bytes
  std::uint32_t size{0};

  void resize(std::uint32_t count) {
    bytes.reset(new std::uint8_t[count]);
    size = count;
  }
};

}  // namespace extperfc::benchmark

// What roscpp asks about a message.
namespace ros {
namespace message_traits {

template <>
struct IsMessage<extperfc::benchmark::RawMessage> : TrueType {};

template <>
struct MD5Sum<extperfc::benchmark::RawMessage> {
  static const char* value() { return "*"; }
  static const char* value(const extperfc::benchmark::RawMessage& /*message*/) { return value(); }
};

template <>
struct DataType<extperfc::benchmark::RawMessage> {
  static const char* value() { return "*"; }
  static const char* value(const extperfc::benchmark::RawMessage& /*message*/) { return value(); }
};

template <>
struct Definition<extperfc::benchmark::RawMessage> {
  static const char* value() { return ""; }
  static const char* value(const extperfc::benchmark::RawMessage& /*message*/) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<extperfc::benchmark::RawMessage> {
  using Message = extperfc::benchmark::RawMessage;

  template <typename Stream>
  static void write(Stream& stream, const Message& message) {
    std::memcpy(stream.advance(message.size), message.bytes.get(), message.size);
  }
  template <typename Stream>
  static void read(Stream& stream, Message& message) {
    message.resize(stream.getLength());
    std::memcpy(message.bytes.get(), stream.advance(message.size), message.size);
  }
  static std::uint32_t serializedLength(const Message& message) { return message.size; }
};

}  // namespace serialization
}  // namespace ros
