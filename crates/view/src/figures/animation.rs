//! The motion as an animated GIF; two plans play side by side, in step.
//!
//! All frames share one palette, taken from some of them, so that the background does not flicker; of each frame only
//! the rectangle that changed is stored.

use crate::ViewError;
use crate::meshes::Meshes;
use crate::motion::Motion;
use crate::render::{Picture, Scenery};
use color_quant::NeuQuant;
use gif::{Encoder, Frame, Repeat};
use std::borrow::Cow;

/// Time from frame to frame [hundredths of a second].
const DELAY: u16 = 8;

/// The last frame stays [hundredths of a second].
const PAUSE: u16 = 120;

/// Height of the pictures [pixels].
const HEIGHT: usize = 360;

/// The palette is taken from so many frames.
const SAMPLED: usize = 6;

/// The GIF file.
pub(crate) fn animation(motions: &[Motion], meshes: &Meshes) -> Result<Vec<u8>, ViewError> {
    let sceneries: Vec<_> = motions.iter().map(|x| Scenery::new(x, meshes)).collect();
    let cameras: Vec<_> = sceneries.iter().map(|x| x.camera([0.8, 1.7])).collect();
    let longest = motions
        .iter()
        .map(|x| x.plan.duration())
        .fold(0.0, f64::max);
    let picture = |time: f64| {
        let each = sceneries.iter().zip(&cameras).zip(motions);
        let pictures = each.map(|((scenery, camera), motion)| {
            scenery.picture(time.min(motion.plan.duration()), camera, HEIGHT)
        });
        let mut joined = beside(&pictures.collect::<Vec<_>>());
        progress(&mut joined, time / longest);
        joined
    };
    let n_frames = (longest * 100.0 / f64::from(DELAY)).ceil() as usize;
    let frames: Vec<_> = (0..=n_frames)
        .map(|i| picture(longest * i as f64 / n_frames as f64))
        .collect();
    encode(&frames).map_err(|error| ViewError::Figure {
        what: error.to_string(),
    })
}

fn encode(frames: &[Picture]) -> Result<Vec<u8>, gif::EncodingError> {
    let step = (frames.len() / SAMPLED).max(1);
    let sample = frames.iter().step_by(step).flat_map(|x| rgba(&x.rgb));
    let palette = NeuQuant::new(7, 256, &sample.collect::<Vec<_>>());
    let (width, height) = (frames[0].width, frames[0].height);
    let mut file = Vec::new();
    let mut encoder = Encoder::new(
        &mut file,
        width as u16,
        height as u16,
        &palette.color_map_rgb(),
    )?;
    encoder.set_repeat(Repeat::Infinite)?;
    let mut shown: Option<Vec<u8>> = None;
    for (i, frame) in frames.iter().enumerate() {
        let indices: Vec<u8> = rgba(&frame.rgb)
            .collect::<Vec<_>>()
            .chunks_exact(4)
            .map(|p| palette.index_of(p) as u8)
            .collect();
        let [left, top, wide, high] = changed(shown.as_deref(), &indices, width, height);
        let rows =
            (top..top + high).flat_map(|y| &indices[y * width + left..y * width + left + wide]);
        encoder.write_frame(&Frame {
            delay: if i + 1 == frames.len() { PAUSE } else { DELAY },
            left: left as u16,
            top: top as u16,
            width: wide as u16,
            height: high as u16,
            buffer: Cow::Owned(rows.copied().collect()),
            ..Frame::default()
        })?;
        shown = Some(indices);
    }
    drop(encoder);
    Ok(file)
}

fn rgba(rgb: &[u8]) -> impl Iterator<Item = u8> + '_ {
    rgb.chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255])
}

/// Left, top, width and height of what differs; at least one pixel.
fn changed(before: Option<&[u8]>, now: &[u8], width: usize, height: usize) -> [usize; 4] {
    let Some(before) = before else {
        return [0, 0, width, height];
    };
    let (mut low, mut high) = ([width, height], [0, 0]);
    for (i, _) in now
        .iter()
        .zip(before)
        .enumerate()
        .filter(|(_, (x, y))| x != y)
    {
        for (k, at) in [i % width, i / width].into_iter().enumerate() {
            (low[k], high[k]) = (low[k].min(at), high[k].max(at + 1));
        }
    }
    if high[0] == 0 {
        [0, 0, 1, 1]
    } else {
        [low[0], low[1], high[0] - low[0], high[1] - low[1]]
    }
}

/// Pictures of one height beside one another.
fn beside(pictures: &[Picture]) -> Picture {
    let height = pictures[0].height;
    let row = |y: usize| {
        let part = move |x: &Picture| x.rgb[3 * y * x.width..3 * (y + 1) * x.width].to_vec();
        pictures.iter().flat_map(part)
    };
    Picture {
        width: pictures.iter().map(|x| x.width).sum(),
        height,
        rgb: (0..height).flat_map(row).collect(),
    }
}

/// A bar along the bottom that grows with time.
fn progress(picture: &mut Picture, share: f64) {
    let done = (share * picture.width as f64).round() as usize;
    for y in picture.height - 3..picture.height {
        for x in 0..picture.width {
            let color = if x < done {
                [31, 111, 208]
            } else {
                [221, 226, 233]
            };
            picture.rgb[3 * (y * picture.width + x)..][..3].copy_from_slice(&color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_changed_is_stored() {
        let before = vec![0; 12];
        let mut now = before.clone();
        assert_eq!(changed(None, &now, 4, 3), [0, 0, 4, 3]);
        assert_eq!(changed(Some(&before), &now, 4, 3), [0, 0, 1, 1]);
        (now[5], now[10]) = (1, 1);
        assert_eq!(changed(Some(&before), &now, 4, 3), [1, 1, 2, 2]);
    }
}
