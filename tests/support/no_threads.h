#pragma once
// A process that gets no more threads, as at the limit of a machine or container: new ones are given a stack that fits into no
// address space.

#include <pthread.h>

#include <gtest/gtest.h>

namespace heliograph::test {

class NoThreads {
public:
    NoThreads() {
        EXPECT_EQ(pthread_getattr_default_np(&before_), 0);
        pthread_attr_t attributes = before_;
        EXPECT_EQ(pthread_attr_setstacksize(&attributes, size_t(1) << 50), 0);
        EXPECT_EQ(pthread_setattr_default_np(&attributes), 0);
    }
    NoThreads(const NoThreads&) = delete;
    NoThreads& operator=(const NoThreads&) = delete;
    ~NoThreads() { EXPECT_EQ(pthread_setattr_default_np(&before_), 0); }

private:
    pthread_attr_t before_;
};

}  // namespace heliograph::test
