//! Counts what each thread has allocated, for tests of how much memory something takes: unlike a process's resident size,
//! the count is the same in every run.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// The system's allocator, with a count for every thread. What a thread frees that another has allocated, is taken from
/// its own count.
struct Counting;

#[global_allocator]
static COUNTING: Counting = Counting;

thread_local! {
    static LIVE: Cell<i64> = const { Cell::new(0) };
    static PEAK: Cell<i64> = const { Cell::new(0) };
}

fn add(bytes: i64) {
    // While a thread ends its counts are gone; nobody asks for them then.
    let _ = LIVE.try_with(|live| {
        live.set(live.get() + bytes);
        PEAK.with(|peak| peak.set(peak.get().max(live.get())));
    });
}

// SAFETY: everything is the system allocator's; counting allocates nothing.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size() as i64);
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        add(layout.size() as i64);
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        add(size as i64 - layout.size() as i64);
        unsafe { System.realloc(at, layout, size) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        add(-(layout.size() as i64));
        unsafe { System.dealloc(at, layout) }
    }
}

/// What this thread has allocated and not freed.
pub(crate) fn live() -> i64 {
    LIVE.with(Cell::get)
}

/// The most that this thread had allocated at a time while something ran, beyond what it had before. Only what this very
/// thread allocates counts.
pub(crate) fn peak_of<T>(run: impl FnOnce() -> T) -> (T, u64) {
    let before = live();
    let outer = PEAK.with(|peak| peak.replace(before));
    let result = run();
    let peak = PEAK.with(|peak| peak.replace(peak.get().max(outer)));
    (result, (peak - before).max(0) as u64)
}

#[test]
fn what_is_freed_does_not_count() {
    let (kept, peak) = peak_of(|| {
        drop(vec![0u8; 100_000]);
        vec![0u8; 40_000]
    });
    assert_eq!((kept.len(), peak), (40_000, 100_000));
    assert_eq!(peak_of(|| ()).1, 0);
}
