#include "extperfc/base/md5.hpp"

#include <array>
#include <stdexcept>

#include <openssl/evp.h>

#include "base/hex.hpp"

namespace extperfc {

std::string md5_hex(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_md5(), nullptr) != 1)
    throw std::runtime_error("OpenSSL computes no MD5: is it built or configured without it?");
  return to_hex(digest.data(), size);
}

}  // namespace extperfc
