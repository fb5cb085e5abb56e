// Tables 1 and 2 of Gribel et al. 2013: sample test efficiency and relative time of the traversals.

/** `what` of a cell and of the paper's, with how it is shown. */
function traversalTable(caption, settings, rows, what, format) {
  const columns = [
    {title: 'Scene', text: true, value: (row) => row.scene},
    {title: 'Primitives', value: (row) => row.primitives, node: (row, found) => whole(found)},
    ...settings.map(({id, label}) => ({
                      title: label,
                      value: (row) => row.cells?.[id]?.[what],
                      node: (row, found) => {
                        const paper = row.paper?.[id]?.[what];
                        return [format(found), isNumber(paper) ? ` (${format(paper)})` : null];
                      }
                    })),
  ];
  return sortableTable(caption, columns, rows, (row) => (row.error ? `failed: ${row.error}` : null));
}

function traversalSection(traversal) {
  const {settings, rows, findings} = traversal;
  const stands = rows.filter((row) => row.paper_scene && row.paper_scene !== row.scene)
                     .map((row) => `${row.scene} for ${row.paper_scene}`);
  return element(
      'section', {id: 'traversal', 'aria-labelledby': 'traversal-title'},
      element('h2', {id: 'traversal-title'}, 'Tables 1 and 2 of Gribel et al. 2013, redone'),
      element('p', {}, listOf(findings).join(' ')),
      element(
          'p', {class: 'soft'},
          `One thread, ${rows[0].samples} samples a pixel. In brackets what the paper has` +
              (stands.length > 0 ? `; made-up scenes stand in: ${stands.join(', ')}.` : '.')),
      element('h3', {}, 'Samples inside of all that are tested'),
      traversalTable('Sample test efficiency', settings, rows, 'efficiency', percent),
      element('h3', {}, 'CPU time relative to tiles of 4×4 px'),
      traversalTable('Relative time', settings, rows, 'relative_time', fixed(2)));
}
