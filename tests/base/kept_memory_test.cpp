#include "isopach/base/kept_memory.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "isopach/base/array.hpp"
#include "isopach/base/parallel.hpp"
#include "tests/support/random.hpp"

namespace isopach {
namespace {

TEST(KeptMemory, NothingIsKeptWithoutOne) {
  { Array<double> array(1000000); }
  EXPECT_EQ(kept_bytes(), 0u);
}

TEST(KeptMemory, TheNextArrayOfTheSizeGetsIt) {
  {
    const KeptMemory kept;
    const double* first = nullptr;
    {
      Array<double> array(1000000);
      first = array.data();
    }
    EXPECT_EQ(kept_bytes() >= 8000000, memory_is_kept);
    const Array<double> nearly(999000);
    EXPECT_EQ(nearly.data() == first, memory_is_kept);
    EXPECT_EQ(kept_bytes(), 0u);
  }
  EXPECT_EQ(kept_bytes(), 0u);
}

TEST(KeptMemory, IsGivenBackByTheLastOfThem) {
  {
    const KeptMemory outer;
    {
      const KeptMemory inner;
      { Array<double> array(1000000); }
    }
    EXPECT_EQ(kept_bytes() > 0, memory_is_kept);
  }
  EXPECT_EQ(kept_bytes(), 0u);
}

TEST(KeptMemory, WithWhatIsInUseItStaysBelowThePeak) {
  const KeptMemory kept;
  { Array<char> array(std::size_t{64} << 20); }
  // An array of another size: what waits must go, or both would be held.
  const Array<char> larger(std::size_t{40} << 20);
  EXPECT_EQ(kept_bytes(), 0u);
}

// Every size from the least on: the block that comes back must be large enough for any array of its size.
TEST(KeptMemory, BlocksHoldWhatWasAskedFor) {
  const KeptMemory kept;
  test::Random random(3);
  for (int i = 0; i < 3000; ++i) {
    const std::size_t bytes = kept_from + random.below(i % 3 == 0 ? 64 : 3000000);
    char* const memory = static_cast<char*>(take_memory(bytes));
    std::memset(memory + bytes - 4096, i, 4096);
    give_memory(memory, bytes);
  }
}

TEST(KeptMemory, EachBlockHasOneOwnerAmongThreads) {
  const KeptMemory kept;
  std::size_t wrong = 0;
  run_with_threads(7, [&] {
    for_blocks(2000, 1, [&](std::size_t i, std::size_t) {
      Array<std::size_t> array(kept_from / 8 + i % 5 * 1000);
      for (std::size_t k = 0; k < array.size(); k += 512) array[k] = i;
      for (std::size_t k = 0; k < array.size(); k += 512)
        if (array[k] != i) (void)take_next(wrong, std::size_t{1});
    });
  });
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace isopach
