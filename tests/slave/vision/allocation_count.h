// Counts what is allocated with operator new in this program.
#pragma once

namespace palpate {

int AllocationCount() noexcept;

}  // namespace palpate
