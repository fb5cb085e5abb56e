// Tables that come with their columns and rows: about moving triangles.

function studyTableSection(table) {
  const cell = (found) => (isNumber(found) ? (Number.isInteger(found) ? whole(found) : found.toPrecision(4)) : found);
  const columns = table.columns.map((title, index) => ({
                                      title,
                                      text: index === 0,
                                      value: (row) => row[index],
                                      node: (row, found) => cell(found),
                                    }));
  return element(
      'section', {id: table.id, 'aria-labelledby': `${table.id}-title`},
      element('h2', {id: `${table.id}-title`}, table.title), element('p', {class: 'soft'}, table.note),
      sortableTable(table.title, columns, table.rows, () => null));
}
