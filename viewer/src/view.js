// The view of a mesh in a page: reads what the page holds, draws it, and answers to the page's controls.

import { readMesh } from './mesh.js';
import { Stage } from './stage.js';
import { drape, heightColours, heightLegend } from './colours.js';
import { factors } from './factors.js';
import { showPlace } from './place.js';

const section = document.getElementById('view');
const settings = JSON.parse(document.getElementById('view-settings').textContent);
const part = name => section.querySelector(`[name=${name}]`);

try {
  await begin();
  section.dataset.state = 'drawn';
} catch (error) {
  section.querySelector('.readout').textContent = `The view cannot be shown: ${error.message}`;
  section.dataset.state = 'failed';
} finally {
  section.hidden = false;
}

async function begin() {
  const canvas = section.querySelector('canvas');
  const mesh = await readMesh(document.getElementById('view-mesh').textContent.trim());
  // A canvas that is not shown has no size.
  section.hidden = false;
  const stage = new Stage(canvas, mesh);

  const colours = part('colours');
  for (const { name, image } of settings.drapes) colours.add(new Option(name, image));
  const legend = chosen => {
    if (chosen === 'heights') return heightLegend(mesh, settings);
    const map = document.getElementById(chosen)?.closest('figure').querySelector('.legend');
    return map ? map.cloneNode(true).childNodes : [];
  };
  const paint = async () => {
    if (colours.value === 'heights') stage.paint({ colours: heightColours(mesh) });
    else if (colours.value === 'none') stage.paint({});
    else stage.paint({ image: await drape(document.getElementById(colours.value)), at: settings.samples });
    section.querySelector('.legend').replaceChildren(...legend(colours.value));
    section.dataset.colours = colours.value;
  };
  colours.addEventListener('change', paint);

  const { list, usual } = factors(stage.extent, stage.size.y);
  const slider = part('factor'), said = section.querySelector('output');
  slider.max = list.length - 1;
  const stretch = () => {
    stage.stretch(list[slider.value]);
    said.textContent = `× ${list[slider.value]}`;
  };
  slider.value = list.indexOf(usual);
  slider.addEventListener('input', stretch);

  const edges = part('edges');
  edges.addEventListener('change', () => stage.showEdges(edges.checked));
  part('above').addEventListener('click', () => stage.lookFromAbove());
  part('reset').addEventListener('click', () => {
    slider.value = list.indexOf(usual);
    stretch();
    stage.lookAslant();
  });

  await paint();
  stretch();
  stage.lookAslant();
  stage.showEdges(edges.checked);
  showPlace(section.querySelector('.readout'), canvas, stage, mesh.frame, settings);
}
