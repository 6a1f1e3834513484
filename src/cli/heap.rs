//! What the allocator keeps of memory that has been freed.

/// Blocks of at least so many bytes are taken from the system each by itself, and go back to it when they are freed.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const OWN_BYTES: std::ffi::c_int = 1 << 20;

#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[allow(unsafe_code)]
// SAFETY: the C library has this function, it takes two numbers and touches no memory of its caller's.
unsafe extern "C" {
    safe fn mallopt(parameter: std::ffi::c_int, value: std::ffi::c_int) -> std::ffi::c_int;
}

/// Has large blocks go back to the system when they are freed. By itself the GNU C library raises the size from which on it
/// does so, up to 32 MiB, whenever such a block is freed, and keeps twice that of each thread's: what dense tiles have needed
/// would stay. To be called first.
pub(super) fn give_back_large_blocks() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        const M_MMAP_THRESHOLD: std::ffi::c_int = -3;
        // A library that does not take it keeps more memory, nothing else.
        let _ = mallopt(M_MMAP_THRESHOLD, OWN_BYTES);
    }
}
