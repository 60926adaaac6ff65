//! Files of strands in the format of TressFX.

/// A .tfx file of strands with the same number of points, of either version of the format.
///
/// `numbers` has the points, each of three numbers, or of four from version 4 on. If `uv`, two numbers of each strand
/// follow.
pub fn tfx(version: f32, [strands, points]: [usize; 2], numbers: impl IntoIterator<Item = f32>, uv: bool) -> Vec<u8> {
    let (header, at, width) = if version < 4.0 { (296, 144, 3) } else { (160, 12, 4) };
    let mut bytes = vec![0; header];
    let mut put = |at: usize, word: u32| bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    put(0, version.to_bits());
    put(4, strands as u32);
    put(8, points as u32);
    put(at, header as u32);
    put(at + 4, if uv { (header + strands * points * width * 4) as u32 } else { 0 });
    bytes.extend(numbers.into_iter().flat_map(f32::to_le_bytes));
    bytes
}

/// A .tfx file of 3 strands with 4 points and uv.
pub fn small_tfx(version: f32) -> Vec<u8> {
    let numbers = 12 * if version < 4.0 { 3 } else { 4 };
    let points = (0..numbers).map(|i| i as f32 * 0.5);
    tfx(version, [3, 4], points.chain((0..6).map(|i| i as f32 / 8.0)), true)
}
