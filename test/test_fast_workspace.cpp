#include "compression/fast_coder.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

namespace {

using pcl_ext::io::FastCoder;
using pcl_ext::io::FastWorkspace;
using pcl_ext::io::FastWorkspacePool;

TEST(FastWorkspacePool, TheLastOneGivenBackIsTakenFirst)
{
  FastWorkspacePool pool;
  std::unique_ptr<FastWorkspace> first = pool.take();
  std::unique_ptr<FastWorkspace> second = pool.take();
  ASSERT_NE(first, nullptr);
  ASSERT_NE(second, nullptr);
  const FastWorkspace* const first_address = first.get();
  const FastWorkspace* const second_address = second.get();
  EXPECT_NE(first_address, second_address);
  pool.giveBack(std::move(second));
  pool.giveBack(std::move(first));
  EXPECT_EQ(pool.take().get(), first_address);
  EXPECT_EQ(pool.take().get(), second_address);
}

TEST(FastWorkspacePool, LivesAsLongAsItsCoders)
{
  std::weak_ptr<FastWorkspacePool> pool;
  {
    const FastCoder coder;
    pool = FastWorkspacePool::shared();
    EXPECT_EQ(pool.lock(), FastWorkspacePool::shared());
  }
  EXPECT_TRUE(pool.expired());
}

} // namespace
