// Stands in for libFuzzer where there is none: runs a fuzzer on the files it is given, once each.
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/fuzz/check.h"

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s FILE...\n", argv[0]);
    return 2;
  }
  for (int i = 1; i < argc; ++i) {
    std::ifstream file(argv[i], std::ios::binary);
    if (!file) {
      std::fprintf(stderr, "%s cannot be opened\n", argv[i]);
      return 2;
    }
    std::fprintf(stderr, "%s\n", argv[i]);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  }
  return 0;
}
