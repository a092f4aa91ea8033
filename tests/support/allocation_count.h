// Counts heap allocations of a test program: linking palpate_allocation_count replaces its
// operators new. Under clang's thread sanitizer, calls of malloc are counted, too.
#pragma once

namespace palpate {

// Number of calls of operator new so far, of all threads.
long AllocationCount() noexcept;
// Number of calls of the calling thread.
long OwnAllocationCount() noexcept;

}  // namespace palpate
