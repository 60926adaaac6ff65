//! The key of a sample: MurmurHash3 with 128 bits (Appleby 2011, public domain), as the library of Alembic has it.

/// The key of these bytes. Programs take samples with the same key as equal.
pub(super) fn key(bytes: &[u8]) -> [u8; 16] {
    const C: [u64; 2] = [0x87c3_7b91_1142_53d5, 0x4cf5_ad43_2745_937f];
    let mix = |word: u64, k: usize| {
        let turn = [31, 33][k];
        word.wrapping_mul(C[k]).rotate_left(turn).wrapping_mul(C[1 - k])
    };
    let [mut a, mut b] = [0u64; 2];
    let (blocks, tail) = bytes.as_chunks::<16>();
    for block in blocks {
        let words = block.as_chunks::<8>().0;
        let [low, high] = [u64::from_le_bytes(words[0]), u64::from_le_bytes(words[1])];
        a = (a ^ mix(low, 0)).rotate_left(27).wrapping_add(b).wrapping_mul(5).wrapping_add(0x52dc_e729);
        b = (b ^ mix(high, 1)).rotate_left(31).wrapping_add(a).wrapping_mul(5).wrapping_add(0x3849_5ab5);
    }
    let mut rest = [0u8; 16];
    rest[..tail.len()].copy_from_slice(tail);
    let words = rest.as_chunks::<8>().0;
    b ^= mix(u64::from_le_bytes(words[1]), 1);
    a ^= mix(u64::from_le_bytes(words[0]), 0);
    let finish = |mut word: u64| {
        word = (word ^ (word >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        word = (word ^ (word >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
        word ^ (word >> 33)
    };
    let length = bytes.len() as u64;
    (a, b) = (a ^ length, b ^ length);
    a = a.wrapping_add(b);
    b = b.wrapping_add(a);
    (a, b) = (finish(a), finish(b));
    a = a.wrapping_add(b);
    b = b.wrapping_add(a);
    let mut found = [0; 16];
    found[..8].copy_from_slice(&a.to_le_bytes());
    found[8..].copy_from_slice(&b.to_le_bytes());
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known values of the reference implementation (MurmurHash3_x64_128 with the seed 0).
    #[test]
    fn known_keys_are_found() {
        let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        assert_eq!(hex(&key(b"")), "00000000000000000000000000000000");
        let words = |text: &[u8]| {
            let key = key(text);
            let word = |at: usize| u64::from_le_bytes(key[at..at + 8].try_into().unwrap());
            [word(0), word(8)]
        };
        assert_eq!(words(b"hello"), [0xcbd8_a7b3_41bd_9b02, 0x5b1e_906a_48ae_1d19]);
        assert_eq!(
            words(b"The quick brown fox jumps over the lazy dog"),
            [0xe34b_bc7b_bc07_1b6c, 0x7a43_3ca9_c49a_9347]
        );
    }
}
