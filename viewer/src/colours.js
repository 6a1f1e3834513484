// Colours of the surface: by height, or those of a map of the page.

import { CanvasTexture, Color, NearestFilter, SRGBColorSpace } from 'three';

// From low to high; light changes one way only, so that it reads in grey, too.
const HEIGHTS = ['#2f5d50', '#5a8a5a', '#9bb06a', '#d3c58a', '#e6d6b8', '#fbf7f0'].map(name => new Color(name));

// For each geometry red, green and blue of its vertices.
export function heightColours({ geometries }) {
  const [low, high] = range(geometries), colour = new Color();
  return geometries.map(geometry => {
    const positions = geometry.getAttribute('position'), out = new Float32Array(3 * positions.count);
    for (let i = 0; i < positions.count; i++) {
      const share = high > low ? (positions.getY(i) - low) / (high - low) : 0.5;
      const step = Math.min(Math.floor(share * (HEIGHTS.length - 1)), HEIGHTS.length - 2);
      colour.lerpColors(HEIGHTS[step], HEIGHTS[step + 1], share * (HEIGHTS.length - 1) - step).toArray(out, 3 * i);
    }
    return out;
  });
}

// Colours and their heights, as the legends of maps have them.
export function heightLegend({ geometries, frame }, { heightDigits, unit }) {
  const [low, high] = range(geometries);
  // Of what spans hundreds nobody reads the digits after the point.
  const digits = high - low > 100 ? 0 : heightDigits;
  const entry = (colour, i) => {
    const [, , height] = frame.toMap({ x: 0, y: low + ((high - low) * i) / (HEIGHTS.length - 1), z: 0 });
    const swatch = document.createElement('i'), words = document.createElement('span');
    swatch.style.background = `#${colour.getHexString()}`;
    words.append(swatch, `${height.toFixed(digits)}${unit}`);
    return words;
  };
  return HEIGHTS.map(entry);
}

const range = geometries => [
  Math.min(...geometries.map(geometry => geometry.boundingBox.min.y)),
  Math.max(...geometries.map(geometry => geometry.boundingBox.max.y)),
];

// The image of a map of the page, on grey.
export async function drape(element) {
  const picture = new Image();
  picture.src = element.getAttribute('href');
  await picture.decode();
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [picture.width, picture.height];
  const context = canvas.getContext('2d');
  context.fillStyle = '#c9cdd2';
  context.fillRect(0, 0, canvas.width, canvas.height);
  // Maps have a hillshade below, and are translucent for it; here the light shades them.
  for (let i = 0; i < 3; i++) context.drawImage(picture, 0, 0);
  const texture = new CanvasTexture(canvas);
  texture.flipY = false;
  texture.colorSpace = SRGBColorSpace;
  texture.magFilter = texture.minFilter = NearestFilter;
  texture.generateMipmaps = false;
  return texture;
}
