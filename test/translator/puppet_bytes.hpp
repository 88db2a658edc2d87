#pragma once

#include <ros/serialization.h>

#include "test/translator/puppet.hpp"

namespace puppet {

template <class Message>
Bytes to_bytes(const Message& message) {
  Bytes bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(stream, message);
  return bytes;
}

/// Throws ros::Exception when the bytes end early.
template <class Message>
Message from_bytes(const Bytes& bytes) {
  Message message;
  Bytes copy = bytes;
  ros::serialization::IStream stream(copy.data(), static_cast<std::uint32_t>(copy.size()));
  ros::serialization::deserialize(stream, message);
  return message;
}

}  // namespace puppet
