//! Zero-initialised arrays for factors and update matrices.

use std::ops::{Deref, DerefMut};

/// Zero-initialised array whose pages are committed on first touch.
///
/// Large arrays request huge pages from the operating system. A factor is written once from end to
/// end, and with ordinary pages a tenth of that time goes into page faults.
pub(crate) struct Zeroed<T> {
    memory: Memory<T>,
}

enum Memory<T> {
    Heap(Vec<T>),
    Pages { map: memmap2::MmapMut, entries: usize },
}

/// Size in bytes from which huge pages can pay off.
const LARGE: usize = 4 << 20;

impl<T: bytemuck::Pod> Zeroed<T> {
    /// Allocates the array; `None` if there is not enough memory.
    pub(crate) fn new(entries: usize) -> Option<Self> {
        let bytes = entries.checked_mul(size_of::<T>())?;
        if bytes >= LARGE
            && let Ok(map) = memmap2::MmapMut::map_anon(bytes)
        {
            #[cfg(target_os = "linux")]
            // Only a hint: failure is harmless.
            let _ = map.advise(memmap2::Advice::HugePage);
            return Some(Zeroed { memory: Memory::Pages { map, entries } });
        }
        let values = bytemuck::allocation::try_zeroed_vec(entries).ok()?;
        Some(Zeroed { memory: Memory::Heap(values) })
    }
}

impl<T: bytemuck::Pod> Deref for Zeroed<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        match &self.memory {
            Memory::Heap(values) => values,
            Memory::Pages { map, entries } => bytemuck::cast_slice(&map[..entries * size_of::<T>()]),
        }
    }
}

impl<T: bytemuck::Pod> DerefMut for Zeroed<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.memory {
            Memory::Heap(values) => values,
            Memory::Pages { map, entries } => bytemuck::cast_slice_mut(&mut map[..*entries * size_of::<T>()]),
        }
    }
}

impl<T> std::fmt::Debug for Zeroed<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let entries = match &self.memory {
            Memory::Heap(values) => values.len(),
            Memory::Pages { entries, .. } => *entries,
        };
        write!(f, "Zeroed({entries} entries)")
    }
}
